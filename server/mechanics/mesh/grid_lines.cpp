// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/grid_lines.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tenter::mechanics {

namespace {

// The integral of the density from lo to s. Between two places c1 < c2 of `towards` it is, but for
// a factor, (s - c1)^(1/beta) up to the middle and then what the other half lacks of
// (c2 - s)^(1/beta); each is inverted by itself.
class Density {
 public:
  explicit Density(const LineGrading& grading) : beta_(grading.beta) {
    std::vector<double> places = grading.towards_m;
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    if (places.empty()) beta_ = 1.0, places = {grading.lo_m};
    breaks_ = {grading.lo_m};
    const auto add = [&](double from, double to, double nearest) {
      if (!(to > from)) return;
      breaks_.push_back(to);
      nearest_.push_back(nearest);
      total_.push_back(total_.back() + over(from, to, nearest));
    };
    for (std::size_t k = 0; k < places.size(); ++k) {
      const double from = k == 0 ? grading.lo_m : 0.5 * (places[k - 1] + places[k]);
      const double to = k + 1 == places.size() ? grading.hi_m : 0.5 * (places[k] + places[k + 1]);
      add(from, places[k], places[k]);
      add(places[k], to, places[k]);
    }
  }

  double up_to(double s) const {
    const std::size_t piece = piece_of(breaks_, s);
    return total_[piece] + over(breaks_[piece], s, nearest_[piece]);
  }

  double place_at(double integral) const {
    const std::size_t piece = piece_of(total_, integral);
    const double c = nearest_[piece], from = breaks_[piece], rest = integral - total_[piece];
    const double root = std::pow(std::abs(from - c), 1.0 / beta_);
    return from < c ? c - std::pow(std::max(0.0, root - rest), beta_)
                    : c + std::pow(root + rest, beta_);
  }

 private:
  /// Of [from, to] on one side of c.
  double over(double from, double to, double c) const {
    return std::abs(std::pow(std::abs(to - c), 1.0 / beta_) -
                    std::pow(std::abs(from - c), 1.0 / beta_));
  }
  static std::size_t piece_of(const std::vector<double>& rising, double value) {
    const auto above = std::upper_bound(rising.begin() + 1, rising.end() - 1, value);
    return static_cast<std::size_t>(above - rising.begin()) - 1;
  }

  double beta_;
  std::vector<double> breaks_;         ///< lo .. hi
  std::vector<double> total_ = {0.0};  ///< of the density up to each of them
  std::vector<double> nearest_;        ///< place of `towards` between two of them
};

/// Stretches get their cells one by one, where most is left for a cell; what is alike gets one at a
/// time, as long as there are enough.
std::vector<int> share_out(const std::vector<double>& weights, const std::vector<bool>& is_one,
                           int cells) {
  constexpr double kAlike = 1e-6;
  std::vector<int> counts(weights.size(), 1);
  int left = cells - static_cast<int>(weights.size());
  while (left > 0) {
    const auto by_cell = [&](std::size_t k) { return weights[k] / counts[k]; };
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < weights.size(); ++k)
      if (!is_one[k] || weights.size() == 1) order.push_back(k);
    if (order.empty())
      for (std::size_t k = 0; k < weights.size(); ++k) order.push_back(k);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return by_cell(a) > by_cell(b) * (1.0 + kAlike);
    });
    std::size_t first = 0, last = 0;
    for (; first < order.size(); first = last) {
      last = first + 1;
      while (last < order.size() &&
             by_cell(order[last]) > by_cell(order[first]) * (1.0 - 2.0 * kAlike))
        ++last;
      if (static_cast<int>(last - first) <= left) break;
    }
    if (first >= order.size()) first = 0, last = 1;
    for (std::size_t k = first; k < last; ++k) ++counts[order[k]];
    left -= static_cast<int>(last - first);
  }
  return counts;
}

}  // namespace

Expected<std::vector<double>> graded_lines(const LineGrading& grading) {
  const double length = grading.hi_m - grading.lo_m;
  if (!std::isfinite(length) || !(length > 0.0))
    return bad_input("grid lines: length " + std::to_string(length) + " m is not positive");
  if (!(grading.beta >= 1.0) || !std::isfinite(grading.beta))
    return bad_input("grid lines: beta " + std::to_string(grading.beta) + " is below 1");
  for (const double place : grading.towards_m)
    if (!(place >= grading.lo_m && place <= grading.hi_m))
      return bad_input("grid lines: " + std::to_string(place) + " m lies outside");
  std::vector<double> given = grading.through_m;
  given.push_back(grading.lo_m);
  given.push_back(grading.hi_m);
  std::sort(given.begin(), given.end());
  constexpr double kClosest = 1e-6;
  if (given.front() != grading.lo_m || given.back() != grading.hi_m)
    return bad_input("grid lines: a line lies outside");
  for (std::size_t k = 1; k < given.size(); ++k)
    if (!(given[k] - given[k - 1] > kClosest * length))
      return bad_input("grid lines: two at " + std::to_string(given[k]) + " m");
  const std::size_t stretches = given.size() - 1;
  if (grading.cells < static_cast<int>(stretches))
    return bad_input("grid lines: " + std::to_string(grading.cells) + " cells for " +
                     std::to_string(stretches) + " stretches");

  const Density density(grading);
  std::vector<double> weights;
  std::vector<bool> is_one;
  for (std::size_t k = 0; k < stretches; ++k) {
    weights.push_back(density.up_to(given[k + 1]) - density.up_to(given[k]));
    is_one.push_back(std::any_of(grading.one_cell_at_m.begin(), grading.one_cell_at_m.end(),
                                 [&](double at) { return at > given[k] && at < given[k + 1]; }));
  }
  const std::vector<int> counts = share_out(weights, is_one, grading.cells);
  std::vector<double> lines = {grading.lo_m};
  for (std::size_t k = 0; k < stretches; ++k) {
    const double from = density.up_to(given[k]);
    for (int i = 1; i < counts[k]; ++i)
      lines.push_back(density.place_at(from + weights[k] * i / counts[k]));
    lines.push_back(given[k + 1]);
  }
  return lines;
}

}  // namespace tenter::mechanics
