// SPDX-License-Identifier: GPL-3.0-or-later
// Derivatives by differences, the oracle of the exact ones.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <type_traits>
#include <utility>

namespace tenter::testing {

/// Fourth-order central difference of f at x; f may return anything with +, - and scaling.
template <class Function>
auto difference(Function f, double x, double h) {
  using Value = std::decay_t<decltype(f(x))>;  // never an expression that refers to what is gone
  const Value near = f(x + h) - f(x - h);
  const Value far = f(x + 2.0 * h) - f(x - 2.0 * h);
  Value slope = (near * 8.0 - far) * (1.0 / (12.0 * h));
  return slope;
}

/// Scales every tolerance; TENTER_TOLERANCE_SCALE=0 shows the true differences.
inline double tolerance(double value) {
  static const char* text = std::getenv("TENTER_TOLERANCE_SCALE");
  static const double scale = text == nullptr ? 1.0 : std::atof(text);
  return value * scale;
}

/// Collects comparisons of one quantity and judges the largest difference against the largest
/// value, which must not be trivial: so no check passes by being zero.
class Comparison {
 public:
  explicit Comparison(std::string what) : what_(std::move(what)) {}

  void add(double actual, double oracle) {
    scale_ = std::max(scale_, std::abs(oracle));
    worst_ = std::max(worst_, std::abs(actual - oracle));
    finite_ = finite_ && std::isfinite(actual) && std::isfinite(oracle);
  }
  /// `smallest_scale`: what the oracle's largest value must exceed; 0 where the quantity may vanish
  /// altogether.
  /// `rounding`: what the oracle itself may be wrong by.
  void judge(double relative = 1e-6, double smallest_scale = 1e-9, double rounding = 0.0) const {
    EXPECT_TRUE(finite_) << what_;
    EXPECT_TRUE(scale_ > smallest_scale || smallest_scale == 0.0)
        << what_ << ": nothing was compared";
    EXPECT_LE(worst_, tolerance(relative * std::max(scale_, smallest_scale) + rounding)) << what_;
  }
  double scale() const { return scale_; }

 private:
  std::string what_;
  double scale_ = 0.0;
  double worst_ = 0.0;
  bool finite_ = true;
};

/// Numbers for properties: fixed seeds, the same on every machine.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  double between(double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(engine_()) / 4294967295.0;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace tenter::testing
