// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/outliers.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

/// The lower of the two middle values where there are two.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Value minus what a robust line (Theil-Sen) through its neighbours says; the window is the 2h+1
/// values centred on it, or the nearest such where that would run over the end.
std::vector<double> without_trend(const std::vector<double>& x, int half) {
  const int n = static_cast<int>(x.size());
  const int width = 2 * half + 1;
  std::vector<double> y(x.size(), 0.0);
  if (n < width) return y;
  std::vector<double> slopes;
  std::vector<double> levels;
  for (int i = 0; i < n; ++i) {
    const int first = std::clamp(i - half, 0, n - width);
    slopes.clear();
    levels.clear();
    for (int a = first; a < first + width; ++a)
      for (int b = a + 1; b < first + width; ++b)
        if (a != i && b != i)
          slopes.push_back((x[static_cast<std::size_t>(b)] - x[static_cast<std::size_t>(a)]) /
                           (b - a));
    const double slope = median(slopes);
    for (int a = first; a < first + width; ++a)
      if (a != i) levels.push_back(x[static_cast<std::size_t>(a)] + slope * (i - a));
    y[static_cast<std::size_t>(i)] = x[static_cast<std::size_t>(i)] - median(levels);
  }
  return y;
}

/// Median absolute deviation of the values around each place, as a standard deviation.
std::vector<double> local_scale(const std::vector<double>& y, int half) {
  const int n = static_cast<int>(y.size());
  std::vector<double> scale(y.size(), 0.0);
  for (int i = 0; i < n; ++i) {
    std::vector<double> window;
    for (int k = std::max(0, i - half); k < std::min(n, i + half + 1); ++k)
      window.push_back(std::abs(y[static_cast<std::size_t>(k)]));
    scale[static_cast<std::size_t>(i)] = 1.4826 * median(window);
  }
  return scale;
}

/// Frames of one block in the order of the imposed component that moves most.
std::vector<std::size_t> along_strain(const Curves& curves, const std::vector<Row>& rows,
                                      std::size_t first, std::size_t last) {
  Eigen::Vector3d lo = curves.path.q[static_cast<std::size_t>(rows[first].frame)];
  Eigen::Vector3d hi = lo;
  for (std::size_t r = first; r < last; ++r) {
    const Eigen::Vector3d& q = curves.path.q[static_cast<std::size_t>(rows[r].frame)];
    lo = lo.cwiseMin(q);
    hi = hi.cwiseMax(q);
  }
  int driver = 0;
  double most = -1.0;
  for (int i = 0; i < 3; ++i) {
    if (curves.path.is_free[static_cast<std::size_t>(i)] || hi[i] - lo[i] <= most) continue;
    most = hi[i] - lo[i];
    driver = i;
  }
  std::vector<std::size_t> order;
  for (std::size_t r = first; r < last; ++r) order.push_back(r);
  if (most > 1e-9)
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return curves.path.q[static_cast<std::size_t>(rows[a].frame)][driver] <
             curves.path.q[static_cast<std::size_t>(rows[b].frame)][driver];
    });
  return order;
}

/// What the readings before and those after a group say of it, each with a level of its own and
/// both with one slope; in time, within the block. At an end of the block the one side speaks for
/// both.
struct Sides {
  bool any = false;  ///< there are readings enough on one side at least
  double before = 0.0;
  double after = 0.0;
};

/// `suspects` speak for neither side.
Sides sides_of(const std::vector<Row>& rows, const Eigen::VectorXd& residuals,
               const std::vector<bool>& suspects, std::size_t begin, std::size_t first,
               std::size_t last) {
  constexpr std::size_t kReadings = 6;
  constexpr std::size_t kReach = 12;
  constexpr std::size_t kFewest = 3;
  const std::size_t end = begin + suspects.size();
  const auto x = [&](std::size_t r) { return residuals[static_cast<Eigen::Index>(r)]; };
  std::vector<std::size_t> before;
  std::vector<std::size_t> after;
  const auto gather = [&](bool also_suspects) {
    before.clear();
    after.clear();
    for (std::size_t r = first; r > begin && first - r < kReach && before.size() < kReadings; --r) {
      if (rows[r - 1].block != rows[first].block) break;
      if (also_suspects || !suspects[r - 1 - begin]) before.push_back(r - 1);
    }
    for (std::size_t r = last; r < end && r - last < kReach && after.size() < kReadings; ++r) {
      if (rows[r].block != rows[last - 1].block) break;
      if (also_suspects || !suspects[r - begin]) after.push_back(r);
    }
  };
  gather(false);
  // at an end of the block the nearest count, whatever is thought of them
  if (before.size() < kFewest || after.size() < kFewest) gather(true);
  Sides sides;
  if (before.size() < kFewest && after.size() < kFewest) return sides;
  std::vector<double> slopes;
  for (const auto& side : {before, after})
    for (std::size_t a = 0; a < side.size(); ++a)
      for (std::size_t b = a + 1; b < side.size(); ++b)
        slopes.push_back((x(side[b]) - x(side[a])) /
                         (static_cast<double>(side[b]) - static_cast<double>(side[a])));
  const double slope = median(slopes);
  const double middle = 0.5 * static_cast<double>(first + last - 1);
  const auto level = [&](const std::vector<std::size_t>& side) {
    std::vector<double> levels;
    levels.reserve(side.size());
    for (const std::size_t r : side)
      levels.push_back(x(r) + slope * (middle - static_cast<double>(r)));
    return median(levels);
  };
  sides.any = true;
  sides.before = level(before.size() < kFewest ? after : before);
  sides.after = level(after.size() < kFewest ? before : after);
  return sides;
}

}  // namespace

std::vector<Outlier> find_outliers(const DataSet& data, const std::vector<Row>& rows,
                                   const Eigen::VectorXd& residuals,
                                   const OutlierOptions& options) {
  constexpr int kScaleHalfWindow = 25;
  std::vector<Outlier> found;
  std::size_t first = 0;
  while (first < rows.size()) {
    // one channel of one curve: its blocks follow each other
    std::size_t end = first;
    while (end < rows.size() && rows[end].curve == rows[first].curve &&
           rows[end].channel == rows[first].channel)
      ++end;
    const auto i = static_cast<std::size_t>(rows[first].curve);
    const auto c = static_cast<std::size_t>(rows[first].channel);
    const ObservedChannel& channel = data.curves[i].channels[c];
    const double sigma = data.sigma[i][c];

    std::vector<double> deviation(end - first, 0.0);
    std::vector<double> scale(end - first, 0.0);
    double lo = 1e300;
    double hi = -1e300;
    for (std::size_t block = first; block < end;) {
      std::size_t last = block;
      while (last < end && rows[last].block == rows[block].block) ++last;
      const auto order = along_strain(data.curves[i], rows, block, last);
      std::vector<double> x;
      x.reserve(order.size());
      for (const std::size_t r : order) x.push_back(residuals[static_cast<Eigen::Index>(r)]);
      const std::vector<double> y = without_trend(x, options.half_window);
      const std::vector<double> around = local_scale(y, kScaleHalfWindow);
      for (std::size_t k = 0; k < order.size(); ++k) {
        deviation[order[k] - first] = y[k];
        scale[order[k] - first] = around[k];
        const double m = channel.measured[static_cast<std::size_t>(rows[order[k]].frame)];
        lo = std::min(lo, m);
        hi = std::max(hi, m);
      }
      block = last;
    }
    std::vector<double> size;
    size.reserve(deviation.size());
    for (const double v : deviation) size.push_back(std::abs(v));
    // quantised readings have a median deviation of zero: never below the resolution, nor below a
    // declared sigma
    std::vector<double> sorted = size;
    const double whole =
        std::max({1.4826 * median(sorted), channel.resolution / sigma, channel.sigma / sigma});
    const double smallest = options.smallest_share * (hi - lo) / sigma;
    const auto is_far = [&](std::size_t k) {
      return size[k] > options.threshold * std::max(whole, scale[k]) && size[k] > smallest;
    };
    std::vector<bool> suspects(deviation.size());
    for (std::size_t k = 0; k < deviation.size(); ++k) suspects[k] = is_far(k);
    for (std::size_t k = 0; k < deviation.size();) {
      std::size_t stop = k;
      while (stop < deviation.size() && suspects[stop]) ++stop;
      if (stop > k && static_cast<int>(stop - k) <= options.longest) {
        const Sides sides = sides_of(rows, residuals, suspects, first, first + k, first + stop);
        for (std::size_t j = k; j < stop; ++j) {
          const Row& row = rows[first + j];
          // a reading beside a step, or on its way, is as good as one of its sides
          const double x = residuals[static_cast<Eigen::Index>(first + j)];
          const double apart = std::max({std::min(sides.before, sides.after) - x,
                                         x - std::max(sides.before, sides.after), 0.0});
          if (sides.any && apart <= 0.5 * options.threshold * std::max(whole, scale[j])) continue;
          found.push_back({row.curve, row.channel, row.frame, -deviation[j] * sigma,
                           size[j] / std::max({whole, scale[j], 1e-12})});
        }
      }
      k = std::max(stop, k + 1);
    }
    first = end;
  }
  return found;
}

}  // namespace tenter::estimation
