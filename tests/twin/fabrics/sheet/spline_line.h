// SPDX-License-Identifier: GPL-3.0-or-later
// Cubic B-splines along one side of a sheet, over knots at irregular distances.
//
// A knot inside is single (two continuous derivatives), double (one: the curvature may jump there)
// or triple (none: the slope may, too). Ends are clamped: the first function is 1 at 0.
//
//   SplineLine line({0.0, 0.03, 0.03, 0.1});          // knots, doubles written twice
//   const LineValue at = line.at(0.05);               // four functions from at.first on
//
// Immutable; callable from any thread; at() does not allocate.
#pragma once

#include <array>
#include <vector>

namespace tenter::twin {

struct LineValue {
  int first = 0;                     ///< the functions first .. first + 3 are not zero
  std::array<double, 4> value = {};  ///< N
  std::array<double, 4> slope = {};  ///< dN/ds
  std::array<double, 4> curve = {};  ///< d2N/ds2
};

class SplineLine {
 public:
  /// Rising from the line's start to its end; at most three of a kind, the ends once.
  explicit SplineLine(const std::vector<double>& knots);

  int count() const { return static_cast<int>(knots_.size()) - 4; }
  const std::vector<double>& spans() const { return spans_; }  ///< distinct knots
  LineValue at(double s) const;
  /// Greville place of a function: control points that lie there make x(s) = s.
  double place(int function) const;
  /// Functions that are not zero somewhere inside of [lo, hi], whose ends are knots: first, last.
  std::array<int, 2> functions_on(double lo, double hi) const;

 private:
  int span_of(double s) const;
  std::vector<double> knots_;  ///< ends four times
  std::vector<double> spans_;
};

}  // namespace tenter::twin
