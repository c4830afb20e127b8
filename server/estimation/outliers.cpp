// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/outliers.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// value minus the median of the 2h+1 residuals centred on it; the ends of a block, where the window would lean to one
/// side, keep the nearest full window's.
std::vector<double> without_trend(const std::vector<double>& x, int half) {
  const int n = static_cast<int>(x.size());
  std::vector<double> y(x.size(), 0.0);
  if (n < 2 * half + 1) return y;
  for (int i = half; i < n - half; ++i) {
    const std::vector<double> window(x.begin() + (i - half), x.begin() + (i + half + 1));
    y[static_cast<std::size_t>(i)] = x[static_cast<std::size_t>(i)] - median(window);
  }
  return y;
}

}  // namespace

std::vector<Outlier> find_outliers(const DataSet& data, const std::vector<Row>& rows,
                                   const Eigen::VectorXd& residuals,
                                   const OutlierOptions& options) {
  std::vector<Outlier> found;
  std::size_t first = 0;
  while (first < rows.size()) {
    // one channel of one curve: its blocks follow each other
    std::size_t end = first;
    while (end < rows.size() && rows[end].curve == rows[first].curve &&
           rows[end].channel == rows[first].channel)
      ++end;
    std::vector<double> local;
    std::vector<std::size_t> at;
    for (std::size_t block = first; block < end;) {
      std::size_t last = block;
      std::vector<double> x;
      while (last < end && rows[last].block == rows[block].block)
        x.push_back(residuals[static_cast<Eigen::Index>(last++)]);
      const std::vector<double> y = without_trend(x, options.half_window);
      for (std::size_t i = 0; i < y.size(); ++i) {
        local.push_back(y[i]);
        at.push_back(block + i);
      }
      block = last;
    }
    const auto i = static_cast<std::size_t>(rows[first].curve);
    const auto c = static_cast<std::size_t>(rows[first].channel);
    const double sigma = data.sigma[i][c];
    std::vector<double> size;
    for (const double v : local) size.push_back(std::abs(v));
    double scale = size.empty() ? 0.0 : 1.4826 * median(size);
    // quantised readings have a median deviation of zero: never below the resolution
    scale = std::max(scale, data.curves[i].channels[c].resolution / sigma);
    for (std::size_t k = 0; k < local.size() && scale > 0.0;) {
      if (std::abs(local[k]) <= options.threshold * scale) {
        ++k;
        continue;
      }
      std::size_t stop = k;
      while (stop < local.size() && std::abs(local[stop]) > options.threshold * scale) ++stop;
      if (static_cast<int>(stop - k) <= options.longest) {
        for (std::size_t j = k; j < stop; ++j) {
          const Row& row = rows[at[j]];
          found.push_back({row.curve, row.channel, row.frame, -local[j] * sigma,
                           std::abs(local[j]) / scale});
        }
      }
      k = stop;
    }
    first = end;
  }
  return found;
}

}  // namespace tenter::estimation
