// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sheet/spline_line.h"

#include <algorithm>
#include <iterator>

namespace tenter::twin {

SplineLine::SplineLine(const std::vector<double>& knots) : knots_(3, knots.front()) {
  knots_.insert(knots_.end(), knots.begin(), knots.end());
  knots_.insert(knots_.end(), 3, knots.back());
  std::unique_copy(knots.begin(), knots.end(), std::back_inserter(spans_));
}

/// i with knots_[i] <= s < knots_[i + 1], the last span where s is the end.
int SplineLine::span_of(double s) const {
  const auto last = knots_.end() - 4;
  const auto above = std::upper_bound(knots_.begin() + 3, last, s);
  return static_cast<int>(above - knots_.begin()) - 1;
}

// The triangle of Cox and de Boor: N_{i,q} from N_{i,q-1}; derivatives from the lower degrees,
//   N'_{i,q} = q (N_{i,q-1} / (k_{i+q} - k_i) - N_{i+1,q-1} / (k_{i+q+1} - k_{i+1})).
LineValue SplineLine::at(double s) const {
  const int span = span_of(s);
  const auto knot = [&](int i) { return knots_[static_cast<std::size_t>(i)]; };
  // n[q][r]: function span - q + r of degree q
  double n[4][5] = {};
  n[0][0] = 1.0;
  const auto over = [&](double numerator, int from, int to) {
    const double width = knot(to) - knot(from);
    return width > 0.0 ? numerator / width : 0.0;
  };
  for (int q = 1; q <= 3; ++q)
    for (int r = 0; r <= q; ++r) {
      const int i = span - q + r;
      if (r > 0) n[q][r] += over(s - knot(i), i, i + q) * n[q - 1][r - 1];
      if (r < q) n[q][r] += over(knot(i + q + 1) - s, i + 1, i + q + 1) * n[q - 1][r];
    }
  /// Derivative of function span - q + r of degree q, given values of degree q - 1.
  const auto derived = [&](int q, int r, const double* lower) {
    const int i = span - q + r;
    double sum = 0.0;
    if (r > 0) sum += over(q * lower[r - 1], i, i + q);
    if (r < q) sum -= over(q * lower[r], i + 1, i + q + 1);
    return sum;
  };
  LineValue result;
  result.first = span - 3;
  double lower_slope[3];
  for (int r = 0; r < 3; ++r) lower_slope[r] = derived(2, r, n[1]);
  for (std::size_t r = 0; r < 4; ++r) {
    result.value[r] = n[3][r];
    result.slope[r] = derived(3, static_cast<int>(r), n[2]);
    result.curve[r] = derived(3, static_cast<int>(r), lower_slope);
  }
  return result;
}

double SplineLine::place(int function) const {
  const auto f = static_cast<std::size_t>(function);
  return (knots_[f + 1] + knots_[f + 2] + knots_[f + 3]) / 3.0;
}

std::array<int, 2> SplineLine::functions_on(double lo, double hi) const {
  constexpr double kSlack = 1e-9;
  int first = count(), last = -1;
  for (int i = 0; i < count(); ++i) {
    const auto f = static_cast<std::size_t>(i);
    if (knots_[f + 4] <= lo + kSlack || knots_[f] >= hi - kSlack) continue;
    first = std::min(first, i);
    last = std::max(last, i);
  }
  return {first, last};
}

}  // namespace tenter::twin
