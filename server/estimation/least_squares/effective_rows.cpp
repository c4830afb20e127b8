// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/effective_rows.h"

#include <algorithm>

namespace tenter::estimation {

double effective_rows(const std::vector<Row>& rows, const Eigen::VectorXd& residuals,
                      const Eigen::VectorXd& weights) {
  double total = 0.0;
  std::size_t first = 0;
  std::vector<double> x;
  while (first < rows.size()) {
    std::size_t last = first;
    x.clear();
    while (last < rows.size() && rows[last].block == rows[first].block &&
           rows[last].channel == rows[first].channel && rows[last].curve == rows[first].curve) {
      if (weights[static_cast<Eigen::Index>(last)] > 0.0)
        x.push_back(residuals[static_cast<Eigen::Index>(last)]);
      ++last;
    }
    first = last;
    const auto n = x.size();
    if (n == 0) continue;
    double variance = 0.0;
    for (const double v : x) variance += v * v;
    double time = 1.0;
    // sum pairs of lags while they are positive (Geyer's initial positive sequence); the mean is
    // kept in: a residual that keeps its sign over the block is one piece of evidence
    for (std::size_t lag = 1; lag + 1 < n && variance > 0.0; lag += 2) {
      double pair = 0.0;
      for (std::size_t k = lag; k <= lag + 1; ++k)
        for (std::size_t i = 0; i + k < n; ++i) pair += x[i] * x[i + k] / variance;
      if (pair <= 0.0) break;
      time += 2.0 * pair;
    }
    total += std::clamp(static_cast<double>(n) / time, 1.0, static_cast<double>(n));
  }
  return total;
}

}  // namespace tenter::estimation
