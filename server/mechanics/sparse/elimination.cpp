// SPDX-License-Identifier: GPL-3.0-or-later
// Symbols: columns are vertices of the block graph in the order of elimination; the parent of a
// column is the first row below its diagonal in L; the height of a column or supernode is the
// number of scalar rows of L, diagonal included.
#include "server/mechanics/sparse/elimination.h"

#include <algorithm>
#include <utility>

#include "server/mechanics/sparse/block_graph.h"

namespace tenter::mechanics {

namespace {

/// What a supernode costs, in nanoseconds of one core, as measured: an overhead, the flops, the
/// entries that its update adds into others, the entries of its panel.
double modelled_cost(double width, double height) {
  const double below = height - width;
  const double flops = width * below * below + width * width * below + width * width * width / 3.0;
  return 150.0 + 0.02 * flops + 0.2 * below * below + 0.2 * width * height;
}

/// Supernodes are cut above this width: a panel of the factor should stay in the second cache.
constexpr int kWidest = 64;

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<int>(i);
  return place;
}

/// Children before parents, each subtree in one piece: returns order[new] = old.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int size = static_cast<int>(parent.size());
  std::vector<int> child(size, -1), sibling(size, -1), order, stack;
  for (int i = size - 1; i >= 0; --i) {
    if (parent[i] < 0) continue;
    sibling[i] = child[parent[i]];
    child[parent[i]] = i;
  }
  for (int root = 0; root < size; ++root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const int i = stack.back();
      if (child[i] >= 0) {
        stack.push_back(child[i]);
        child[i] = sibling[child[i]];
      } else {
        order.push_back(i);
        stack.pop_back();
      }
    }
  }
  return order;
}

struct Elimination {
  std::vector<int> order;   ///< order[column] = vertex
  std::vector<int> parent;  ///< of each column, -1 at a root
  std::vector<int> height;  ///< of each column
  double flops = 0.0;
};

/// Parents by Liu's algorithm with shortcuts to the highest ancestor found so far.
std::vector<int> elimination_tree(const BlockGraph& graph, const std::vector<int>& order) {
  const std::vector<int> place = inverse(order);
  std::vector<int> parent(order.size(), -1), ancestor(order.size(), -1);
  for (int i = 0; i < graph.size(); ++i) {
    for (int p = graph.start[order[i]]; p < graph.start[order[i] + 1]; ++p) {
      for (int k = place[graph.adjacent[p]]; k >= 0 && k < i;) {
        const int next = ancestor[k];
        ancestor[k] = i;
        if (next < 0) parent[k] = i;
        k = next;
      }
    }
  }
  return parent;
}

/// Row i of L has its entries on the paths from the neighbours of i up to i: walk them once each.
void find_heights(const BlockGraph& graph, Elimination& elimination) {
  const std::vector<int> place = inverse(elimination.order);
  std::vector<int> seen(graph.size(), -1);
  elimination.height.assign(graph.size(), 0);
  for (int i = 0; i < graph.size(); ++i) {
    const int vertex = elimination.order[i];
    seen[i] = i;
    elimination.height[i] += graph.weight(vertex);
    for (int p = graph.start[vertex]; p < graph.start[vertex + 1]; ++p) {
      for (int k = place[graph.adjacent[p]]; k < i && seen[k] != i; k = elimination.parent[k]) {
        elimination.height[k] += graph.weight(vertex);
        seen[k] = i;
      }
    }
  }
  for (int i = 0; i < graph.size(); ++i) {
    for (int c = 0; c < graph.weight(elimination.order[i]); ++c) {
      const double entries = elimination.height[i] - c;
      elimination.flops += entries * entries;
    }
  }
}

Elimination eliminate(const BlockGraph& graph, const std::vector<int>& order) {
  Elimination elimination;
  for (const int i : postorder(elimination_tree(graph, order)))
    elimination.order.push_back(order[i]);
  elimination.parent = elimination_tree(graph, elimination.order);
  find_heights(graph, elimination);
  return elimination;
}

/// A forest of supernodes; columns in the numbering of the elimination.
struct Supernodes {
  std::vector<std::vector<int>> columns;
  std::vector<int> parent;
};

Supernodes merge_columns(const BlockGraph& graph, const Elimination& elimination) {
  const auto weight = [&](int column) { return graph.weight(elimination.order[column]); };
  std::vector<std::vector<int>> columns;
  std::vector<int> owner(graph.size()), width, height;
  for (int j = 0; j < graph.size(); ++j) {
    const bool joins = j > 0 && elimination.parent[j - 1] == j &&
                       elimination.height[j - 1] == elimination.height[j] + weight(j - 1);
    if (!joins) {
      columns.emplace_back();
      width.push_back(0);
      height.push_back(elimination.height[j]);
    }
    owner[j] = static_cast<int>(columns.size()) - 1;
    columns.back().push_back(j);
    width.back() += weight(j);
  }
  const int count = static_cast<int>(columns.size());
  std::vector<int> parent(count, -1);
  std::vector<std::vector<int>> children(count);
  for (int s = 0; s < count; ++s) {
    const int above = elimination.parent[columns[s].back()];
    if (above < 0) continue;
    parent[s] = owner[above];
    children[parent[s]].push_back(s);
  }
  // a merged child brings its own children, which may be merged too; heights below a supernode fit
  // into its parent, so the merged panel is as high as the parent's and the child's columns
  std::vector<bool> gone(count, false);
  for (int s = 0; s < count; ++s) {
    std::vector<int> kept;
    std::vector<int> open = std::move(children[s]);
    for (std::size_t i = 0; i < open.size(); ++i) {
      const int child = open[i];
      const double apart =
          modelled_cost(width[s], height[s]) + modelled_cost(width[child], height[child]);
      const double together = modelled_cost(width[s] + width[child], height[s] + width[child]);
      if (together >= apart) {
        kept.push_back(child);
        continue;
      }
      gone[child] = true;
      width[s] += width[child];
      height[s] += width[child];
      columns[s].insert(columns[s].end(), columns[child].begin(), columns[child].end());
      open.insert(open.end(), children[child].begin(), children[child].end());
      children[child].clear();
    }
    children[s] = std::move(kept);
  }
  Supernodes merged;
  std::vector<int> number(count, -1);
  for (int s = 0; s < count; ++s) {
    if (gone[s]) continue;
    number[s] = static_cast<int>(merged.columns.size());
    std::sort(columns[s].begin(), columns[s].end());
    merged.columns.push_back(std::move(columns[s]));
    merged.parent.push_back(-1);
    for (const int child : children[s]) merged.parent[number[child]] = number[s];
  }
  return merged;
}

/// Rows of one supernode below its own columns, as places of vertices in the final order.
std::vector<std::vector<int>> rows_below(const BlockGraph& graph, const Elimination& elimination,
                                         const Supernodes& nodes, const std::vector<int>& sequence,
                                         const std::vector<int>& place) {
  std::vector<std::vector<int>> rows(nodes.columns.size());
  std::vector<int> seen(graph.size(), -1);
  for (const int s : sequence) {
    const int last = place[elimination.order[nodes.columns[s].back()]];
    const auto add = [&](int row) {
      if (row <= last || seen[row] == s) return;
      seen[row] = s;
      rows[s].push_back(row);
    };
    for (const int row : std::exchange(rows[s], {})) add(row);  // what the children left here
    for (const int column : nodes.columns[s]) {
      const int vertex = elimination.order[column];
      for (int p = graph.start[vertex]; p < graph.start[vertex + 1]; ++p)
        add(place[graph.adjacent[p]]);
    }
    std::sort(rows[s].begin(), rows[s].end());
    if (nodes.parent[s] >= 0) {
      std::vector<int>& above = rows[nodes.parent[s]];
      above.insert(above.end(), rows[s].begin(), rows[s].end());
    }
  }
  return rows;
}

}  // namespace

SupernodalStructure supernodal_structure(const SymmetricPattern& pattern) {
  const BlockGraph graph = block_graph(pattern);
  Elimination elimination = eliminate(graph, minimum_degree_order(graph));
  Elimination dissected = eliminate(graph, nested_dissection_order(graph));
  if (dissected.flops < elimination.flops) elimination = std::move(dissected);
  const Supernodes nodes = merge_columns(graph, elimination);

  const std::vector<int> sequence = postorder(nodes.parent);
  std::vector<int> place(graph.size()), first_unknown;  // of vertices, in the final order
  SupernodalStructure structure;
  structure.flops = elimination.flops;
  for (const int s : sequence) {
    for (const int column : nodes.columns[s]) {
      const int vertex = elimination.order[column];
      place[vertex] = static_cast<int>(first_unknown.size());
      first_unknown.push_back(static_cast<int>(structure.order.size()));
      for (int m = graph.member_start[vertex]; m < graph.member_start[vertex + 1]; ++m)
        structure.order.push_back(graph.members[m]);
    }
  }
  first_unknown.push_back(pattern.size);

  const auto below = rows_below(graph, elimination, nodes, sequence, place);
  int column = 0, vertex = 0;
  for (const int s : sequence) {
    vertex += static_cast<int>(nodes.columns[s].size());
    const int end = first_unknown[vertex];
    const int pieces = (end - column + kWidest - 1) / kWidest;
    for (int piece = pieces; piece > 0; --piece) {
      const int width = (end - column + piece - 1) / piece;
      structure.column_start.push_back(column);
      structure.row_start.push_back(static_cast<int>(structure.rows.size()));
      for (int row = column; row < end; ++row) structure.rows.push_back(row);
      for (const int row : below[s])
        for (int i = first_unknown[row]; i < first_unknown[row + 1]; ++i)
          structure.rows.push_back(i);
      column += width;
    }
  }
  structure.column_start.push_back(column);
  structure.row_start.push_back(static_cast<int>(structure.rows.size()));
  return structure;
}

}  // namespace tenter::mechanics
