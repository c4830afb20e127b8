// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/elements/node_matrix.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

NodeMatrix::NodeMatrix(int nodes, std::vector<std::pair<int, int>> pairs) {
  for (auto& [i, j] : pairs)
    if (i < j) std::swap(i, j);
  for (int i = 0; i < nodes; ++i) pairs.emplace_back(i, i);
  const auto by_column = [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second < b.second : a.first < b.first;
  };
  std::sort(pairs.begin(), pairs.end(), by_column);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  column_start_.assign(static_cast<std::size_t>(nodes) + 1, 0);
  row_.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    row_.push_back(i);
    column_start_[static_cast<std::size_t>(j) + 1] = static_cast<int>(row_.size());
  }
  values_.assign(9 * row_.size(), 0.0);
}

int NodeMatrix::slot(int i, int j) const {
  const auto first = row_.begin() + column_start_[static_cast<std::size_t>(j)];
  const auto last = row_.begin() + column_start_[static_cast<std::size_t>(j) + 1];
  return static_cast<int>(std::lower_bound(first, last, i) - row_.begin());
}

bool NodeMatrix::is_finite() const {
  // a sum is finite only where all are; differences of infinities are not. Eight sums, so that
  // additions need not wait for each other.
  constexpr std::size_t kSums = 8;
  double sums[kSums] = {};
  std::size_t i = 0;
  for (; i + kSums <= values_.size(); i += kSums)
    for (std::size_t k = 0; k < kSums; ++k) sums[k] += values_[i + k];
  for (; i < values_.size(); ++i) sums[0] += values_[i];
  double sum = 0.0;
  for (const double s : sums) sum += s;
  return std::isfinite(sum);
}

void NodeMatrix::multiply_add(const double* x, double* y) const {
  for (int j = 0; j < node_count(); ++j) {
    for (int s = column_start_[static_cast<std::size_t>(j)];
         s < column_start_[static_cast<std::size_t>(j) + 1]; ++s) {
      const int i = row_[static_cast<std::size_t>(s)];
      const double* k = block(s);
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) y[3 * i + r] += k[3 * c + r] * x[3 * j + c];
      if (i == j) continue;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) y[3 * j + c] += k[3 * c + r] * x[3 * i + r];
    }
  }
}

void NodeMatrix::multiply_add(const double* x, double* y, int count,
                              const std::vector<bool>& wanted) const {
  const std::ptrdiff_t rows = 3 * static_cast<std::ptrdiff_t>(node_count());
  for (int j = 0; j < node_count(); ++j) {
    const bool wants_j = wanted[static_cast<std::size_t>(j)];
    for (int s = column_start_[static_cast<std::size_t>(j)];
         s < column_start_[static_cast<std::size_t>(j) + 1]; ++s) {
      const int i = row_[static_cast<std::size_t>(s)];
      const bool wants_i = wanted[static_cast<std::size_t>(i)];
      if (!wants_i && !wants_j) continue;
      const double* k = block(s);
      for (std::ptrdiff_t column = 0; column < count; ++column) {
        const double* from = x + column * rows;
        double* to = y + column * rows;
        for (int c = 0; wants_i && c < 3; ++c)
          for (int r = 0; r < 3; ++r) to[3 * i + r] += k[3 * c + r] * from[3 * j + c];
        for (int c = 0; wants_j && i != j && c < 3; ++c)
          for (int r = 0; r < 3; ++r) to[3 * j + c] += k[3 * c + r] * from[3 * i + r];
      }
    }
  }
}

}  // namespace tenter::mechanics
