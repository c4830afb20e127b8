// SPDX-License-Identifier: GPL-3.0-or-later
// The symbolic phase against elimination on a dense table of booleans.
#include "server/mechanics/sparse/elimination.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <thread>
#include <vector>

#include "server/mechanics/sparse/block_graph.h"
#include "tests/server/mechanics/sparse/matrices.h"

namespace {

using namespace tenter::mechanics;
using namespace tenter::mechanics::test;

struct Eliminated {
  std::vector<std::set<int>> columns;  ///< rows of L, diagonal included
  double flops = 0.0;
};

Eliminated eliminate_plainly(const SymmetricPattern& pattern, const std::vector<int>& order) {
  Eliminated result;
  result.columns.resize(pattern.size);
  for (int col = 0; col < pattern.size; ++col)
    for (int row = col; row < pattern.size; ++row)
      if (pattern.slot(order[row], order[col]) >= 0) result.columns[col].insert(row);
  for (std::set<int>& column : result.columns) {
    result.flops += static_cast<double>(column.size()) * static_cast<double>(column.size());
    if (column.size() < 2) continue;
    std::set<int>& parent = result.columns[*std::next(column.begin())];
    parent.insert(std::next(column.begin()), column.end());
  }
  return result;
}

std::vector<SymmetricPattern> patterns() {
  std::mt19937 random(7);
  return {random_matrix(1, 1, 2, random).pattern,     random_matrix(60, 0, 2, random).pattern,
          random_matrix(90, 120, 2, random).pattern,  random_matrix(150, 60, 9, random).pattern,
          random_matrix(200, 2, 150, random).pattern, cloth_matrix(9, random).pattern};
}

TEST(Elimination, SupernodesHoldEveryEntryOfL) {
  for (const SymmetricPattern& pattern : patterns()) {
    const SupernodalStructure shape = supernodal_structure(pattern);
    std::vector<int> sorted = shape.order;
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < pattern.size; ++i) ASSERT_EQ(sorted[i], i) << "a permutation";

    const Eliminated plain = eliminate_plainly(pattern, shape.order);
    EXPECT_EQ(shape.flops, plain.flops);
    ASSERT_EQ(shape.column_start.back(), pattern.size);
    for (int s = 0; s < shape.count(); ++s) {
      const auto first = shape.rows.begin() + shape.row_start[s];
      const auto last = shape.rows.begin() + shape.row_start[s + 1];
      EXPECT_TRUE(std::is_sorted(first, last));
      EXPECT_EQ(std::adjacent_find(first, last), last) << "each row once";
      for (int i = 0; i < shape.width(s); ++i) ASSERT_EQ(first[i], shape.column_start[s] + i);
      for (int col = shape.column_start[s]; col < shape.column_start[s + 1]; ++col)
        for (const int row : plain.columns[col])
          ASSERT_TRUE(std::binary_search(first, last, row)) << "entry " << row << ' ' << col;
    }
    // an update must find all its rows in its target
    for (int s = 0; s < shape.count(); ++s) {
      for (int i = shape.row_start[s] + shape.width(s); i < shape.row_start[s + 1]; ++i) {
        const int target =
            static_cast<int>(std::upper_bound(shape.column_start.begin(), shape.column_start.end(),
                                              shape.rows[i]) -
                             shape.column_start.begin()) -
            1;
        for (int j = i; j < shape.row_start[s + 1]; ++j)
          ASSERT_TRUE(std::binary_search(shape.rows.begin() + shape.row_start[target],
                                         shape.rows.begin() + shape.row_start[target + 1],
                                         shape.rows[j]));
      }
    }
  }
}

TEST(Elimination, NodesOfAMeshAreOneVertex) {
  std::mt19937 random(7);
  const SymmetricPattern pattern = cloth_matrix(9, random).pattern;
  const BlockGraph graph = block_graph(pattern);
  EXPECT_EQ(3 * graph.size(), pattern.size);
  for (int v = 0; v < graph.size(); ++v) {
    EXPECT_EQ(graph.weight(v), 3);
    for (int p = graph.start[v]; p < graph.start[v + 1]; ++p) {
      const int other = graph.adjacent[p];
      EXPECT_NE(other, v);
      EXPECT_GE(pattern.slot(graph.members[3 * v], graph.members[3 * other + 2]), 0);
    }
  }
}

TEST(Elimination, OrdersAreTheSameFromManyThreads) {
  std::mt19937 random(7);
  const SymmetricPattern pattern = cloth_matrix(30, random).pattern;
  const SupernodalStructure wanted = supernodal_structure(pattern);
  std::vector<SupernodalStructure> found(4);
  std::vector<std::thread> threads;
  threads.reserve(found.size());
  for (SupernodalStructure& shape : found)
    threads.emplace_back([&shape, &pattern] { shape = supernodal_structure(pattern); });
  for (std::thread& thread : threads) thread.join();
  for (const SupernodalStructure& shape : found) {
    EXPECT_EQ(shape.order, wanted.order);
    EXPECT_EQ(shape.rows, wanted.rows);
  }
}

TEST(Elimination, DissectionOfAGridGrowsSlowly) {
  // nested dissection: flops of a planar grid grow with the 1.5th power of the unknowns
  std::mt19937 random(7);
  const SymmetricPattern small = cloth_matrix(20, random).pattern;
  const SymmetricPattern large = cloth_matrix(40, random).pattern;
  const double unknowns = static_cast<double>(large.size) / small.size;
  const double flops = supernodal_structure(large).flops / supernodal_structure(small).flops;
  EXPECT_GT(flops, unknowns);
  EXPECT_LT(std::log(flops) / std::log(unknowns), 1.9);
}

}  // namespace
