// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/symmetric_pattern.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace {

using namespace tenter::mechanics;

TEST(SymmetricPattern, ElementsCoupleTheirUnknowns) {
  const SymmetricPattern pattern = element_pattern(5, {{3, 0, 1}, {1, -1, 4}, {4, 1}});
  const std::set<std::pair<int, int>> wanted = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4},
                                                {1, 0}, {3, 0}, {3, 1}, {4, 1}};
  EXPECT_EQ(pattern.entry_count(), static_cast<int>(wanted.size()));
  std::set<int> slots;
  for (int row = 0; row < 5; ++row) {
    for (int col = 0; col <= row; ++col) {
      const int slot = pattern.slot(row, col);
      EXPECT_EQ(slot, pattern.slot(col, row));
      EXPECT_EQ(slot >= 0, wanted.count({row, col}) == 1) << row << ' ' << col;
      EXPECT_TRUE(slot < 0 || slots.insert(slot).second);
    }
    EXPECT_EQ(pattern.slot(row, row), pattern.column_start[row]) << "diagonal first";
  }
  EXPECT_EQ(pattern.slot(-1, 2), -1);
  EXPECT_EQ(pattern.slot(2, 5), -1);
}

TEST(SymmetricPattern, BlocksAreTheirElementsThreefold) {
  const SymmetricPattern blocks = block_pattern(4, {{1, 2, 1}, {}, {3, -1}, {2}});
  std::vector<std::vector<int>> elements;
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {2, 3}})
    elements.push_back({3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2});
  EXPECT_EQ(blocks, element_pattern(12, elements));
}

TEST(SymmetricPattern, MultiplyUsesBothTriangles) {
  const SymmetricPattern pattern = element_pattern(3, {{0, 1}, {1, 2}});
  const double values[] = {2, 3, 5, 7, 11};  // (0,0) (1,0) (1,1) (2,1) (2,2)
  const double x[] = {1, 10, 100};
  double y[3];
  multiply(pattern, values, x, y);
  EXPECT_EQ(y[0], 2 + 30);
  EXPECT_EQ(y[1], 3 + 50 + 700);
  EXPECT_EQ(y[2], 70 + 1100);
}

TEST(SymmetricPattern, NoUnknownsIsAPattern) {
  const SymmetricPattern pattern = element_pattern(0, {{-1, -1}});
  EXPECT_EQ(pattern.entry_count(), 0);
  EXPECT_EQ(pattern.column_start.size(), 1u);
}

}  // namespace
