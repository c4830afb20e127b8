// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/symmetric_pattern.h"

#include <algorithm>
#include <cstdlib>

namespace tenter::mechanics {

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void sort_unique(std::vector<int>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

int SymmetricPattern::slot(int entry_row, int entry_col) const {
  const int low = std::max(entry_row, entry_col);
  const int col = std::min(entry_row, entry_col);
  if (col < 0 || low >= size) return -1;
  const auto first = row.begin() + column_start[col];
  const auto last = row.begin() + column_start[col + 1];
  const auto found = std::lower_bound(first, last, low);
  return found != last && *found == low ? static_cast<int>(found - row.begin()) : -1;
}

SymmetricPattern element_pattern(int size, const std::vector<std::vector<int>>& element_dofs) {
  std::vector<std::vector<int>> below(size);
  for (int i = 0; i < size; ++i) below[i].push_back(i);
  for (const std::vector<int>& dofs : element_dofs) {
    for (const int col : dofs) {
      require(col < size);
      if (col < 0) continue;
      for (const int low : dofs)
        if (low > col) below[col].push_back(low);
    }
  }
  SymmetricPattern pattern;
  pattern.size = size;
  pattern.column_start.reserve(size + 1);
  for (std::vector<int>& column : below) {
    sort_unique(column);
    pattern.column_start.push_back(pattern.entry_count());
    pattern.row.insert(pattern.row.end(), column.begin(), column.end());
  }
  pattern.column_start.push_back(pattern.entry_count());
  return pattern;
}

SymmetricPattern block_pattern(int nodes, const std::vector<std::vector<int>>& neighbours) {
  require(static_cast<int>(neighbours.size()) == nodes);
  std::vector<std::vector<int>> below(nodes);
  for (int i = 0; i < nodes; ++i) {
    below[i].push_back(i);
    for (const int j : neighbours[i]) {
      require(j < nodes);
      if (j >= 0) below[std::min(i, j)].push_back(std::max(i, j));
    }
  }
  SymmetricPattern pattern;
  pattern.size = 3 * nodes;
  for (int i = 0; i < nodes; ++i) {
    sort_unique(below[i]);
    for (int c = 0; c < 3; ++c) {
      pattern.column_start.push_back(pattern.entry_count());
      for (const int j : below[i])
        for (int r = j == i ? c : 0; r < 3; ++r) pattern.row.push_back(3 * j + r);
    }
  }
  pattern.column_start.push_back(pattern.entry_count());
  return pattern;
}

double mean_diagonal(const SymmetricPattern& pattern, const std::vector<double>& values) {
  double sum = 0.0;
  for (int j = 0; j < pattern.size; ++j)
    sum += values[static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)])];
  return sum / pattern.size;
}

void multiply(const SymmetricPattern& pattern, const double* values, const double* x, double* y) {
  std::fill_n(y, pattern.size, 0.0);
  for (int col = 0; col < pattern.size; ++col) {
    const int first = pattern.column_start[col];
    y[col] += values[first] * x[col];
    for (int p = first + 1; p < pattern.column_start[col + 1]; ++p) {
      y[pattern.row[p]] += values[p] * x[col];
      y[col] += values[p] * x[pattern.row[p]];
    }
  }
}

}  // namespace tenter::mechanics
