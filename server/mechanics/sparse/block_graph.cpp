// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/block_graph.h"

#include <cholmod.h>
#include <algorithm>

#include <cstdint>
#include <numeric>

namespace tenter::mechanics {

namespace {

/// Neighbours of every unknown, itself included, increasing.
struct Neighbours {
  std::vector<int> start, list;

  bool equal(int i, int j) const {
    return std::equal(list.begin() + start[i], list.begin() + start[i + 1], list.begin() + start[j],
                      list.begin() + start[j + 1]);
  }
};

Neighbours closed_neighbours(const SymmetricPattern& pattern) {
  Neighbours all;
  all.start.assign(pattern.size + 1, 0);
  for (int col = 0; col < pattern.size; ++col) {
    for (int p = pattern.column_start[col]; p < pattern.column_start[col + 1]; ++p) {
      ++all.start[col + 1];
      if (pattern.row[p] != col) ++all.start[pattern.row[p] + 1];
    }
  }
  std::partial_sum(all.start.begin(), all.start.end(), all.start.begin());
  all.list.resize(all.start.back());
  std::vector<int> next(all.start.begin(), all.start.end() - 1);
  for (int col = 0; col < pattern.size; ++col) {
    for (int p = pattern.column_start[col]; p < pattern.column_start[col + 1]; ++p) {
      all.list[next[col]++] = pattern.row[p];
      if (pattern.row[p] != col) all.list[next[pattern.row[p]]++] = col;
    }
  }
  return all;
}

std::uint64_t scrambled(int i) {
  std::uint64_t x = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15u;
  x ^= x >> 32;
  return x * 0xD6E8FEB86659FD93u;
}

/// The part of CHOLMOD that is used: a pattern in, an order out.
template <class Method>
std::vector<int> cholmod_order(const BlockGraph& graph, Method method) {
  std::vector<int> start(1, 0), row, order(graph.size());
  std::iota(order.begin(), order.end(), 0);
  for (int v = 0; v < graph.size(); ++v) {
    for (int p = graph.start[v]; p < graph.start[v + 1]; ++p)
      if (graph.adjacent[p] > v) row.push_back(graph.adjacent[p]);
    start.push_back(static_cast<int>(row.size()));
  }
  if (row.empty()) return order;
  cholmod_common common = {};
  cholmod_start(&common);
  common.print = 0;
  cholmod_sparse matrix = {};
  matrix.nrow = matrix.ncol = graph.size();
  matrix.nzmax = row.size();
  matrix.p = start.data();
  matrix.i = row.data();
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_PATTERN;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.packed = 1;
  method(&matrix, order.data(), &common);
  cholmod_finish(&common);
  return order;
}

}  // namespace

BlockGraph block_graph(const SymmetricPattern& pattern) {
  const Neighbours all = closed_neighbours(pattern);
  const int size = pattern.size;
  std::vector<std::uint64_t> hash(size, 0);
  for (int i = 0; i < size; ++i)
    for (int p = all.start[i]; p < all.start[i + 1]; ++p) hash[i] += scrambled(all.list[p]);

  // unknowns of equal closed neighbourhood are neighbours: look only there, at first members
  std::vector<int> vertex(size), first, count;
  std::vector<bool> is_first(size, false);
  for (int i = 0; i < size; ++i) {
    int same = -1;
    for (int p = all.start[i]; p < all.start[i + 1] && all.list[p] < i && same < 0; ++p) {
      const int j = all.list[p];
      if (is_first[j] && hash[j] == hash[i] && all.equal(i, j)) same = vertex[j];
    }
    if (same < 0) {
      same = static_cast<int>(first.size());
      first.push_back(i);
      count.push_back(0);
      is_first[i] = true;
    }
    vertex[i] = same;
    ++count[same];
  }

  BlockGraph graph;
  graph.member_start.assign(first.size() + 1, 0);
  std::partial_sum(count.begin(), count.end(), graph.member_start.begin() + 1);
  graph.members.resize(size);
  std::vector<int> next(graph.member_start.begin(), graph.member_start.end() - 1);
  for (int i = 0; i < size; ++i) graph.members[next[vertex[i]]++] = i;
  graph.start.push_back(0);
  for (const int i : first) {
    for (int p = all.start[i]; p < all.start[i + 1]; ++p) {
      const int j = all.list[p];
      if (is_first[j] && j != i) graph.adjacent.push_back(vertex[j]);
    }
    graph.start.push_back(static_cast<int>(graph.adjacent.size()));
  }
  return graph;
}

std::vector<int> minimum_degree_order(const BlockGraph& graph) {
  return cholmod_order(graph, [](cholmod_sparse* matrix, int* order, cholmod_common* common) {
    return cholmod_amd(matrix, nullptr, 0, order, common);
  });
}

std::vector<int> nested_dissection_order(const BlockGraph& graph) {
  const std::lock_guard lock(metis_mutex());
  return cholmod_order(graph, [](cholmod_sparse* matrix, int* order, cholmod_common* common) {
    return cholmod_metis(matrix, nullptr, 0, 0, order, common);
  });
}

std::mutex& metis_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace tenter::mechanics
