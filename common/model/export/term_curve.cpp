// SPDX-License-Identifier: Apache-2.0
#include "common/model/export/term_curve.h"

#include <algorithm>
#include <cmath>

namespace tenter::model {
namespace {

double knot(int i, int degree, int intervals) {
  return std::clamp(i - degree, 0, intervals);
}

/// Cox - de Boor on clamped even knots; `span` is the interval that x belongs to.
double bspline(int j, int d, int degree, int intervals, int span, double x) {
  if (d == 0) return j == span + degree ? 1.0 : 0.0;
  const double left = knot(j + d, degree, intervals) - knot(j, degree, intervals);
  const double right = knot(j + d + 1, degree, intervals) - knot(j + 1, degree, intervals);
  double value = 0.0;
  if (left > 0.0)
    value +=
        (x - knot(j, degree, intervals)) / left * bspline(j, d - 1, degree, intervals, span, x);
  if (right > 0.0)
    value += (knot(j + d + 1, degree, intervals) - x) / right *
             bspline(j + 1, d - 1, degree, intervals, span, x);
  return value;
}

double bspline_slope(int j, int degree, int intervals, int span, double x) {
  const double left = knot(j + degree, degree, intervals) - knot(j, degree, intervals);
  const double right = knot(j + degree + 1, degree, intervals) - knot(j + 1, degree, intervals);
  double slope = 0.0;
  if (left > 0.0) slope += degree / left * bspline(j, degree - 1, degree, intervals, span, x);
  if (right > 0.0) slope -= degree / right * bspline(j + 1, degree - 1, degree, intervals, span, x);
  return slope;
}

}  // namespace

std::optional<TermCurve> TermCurve::of(const Law& law, Domain domain) {
  static constexpr std::pair<std::string_view, Form> kForms[] = {
      {"linear", Form::linear},
      {"constant_stress", Form::constant_stress},
      {"hermite_stiffness", Form::hermite},
      {"bspline_stiffness", Form::bspline},
      {"convex_spline", Form::convex},
      {"hermite_energy", Form::hermite_energy},
      {"gaussian_energy", Form::gaussian}};
  for (const auto& [name, form] : kForms) {
    if (law.name != name) continue;
    TermCurve curve;
    curve.form_ = form;
    curve.points_ = static_cast<int>(law.parameters.size());
    const auto [lo, hi] = spline_range(law, domain);
    const bool is_bspline = form == Form::bspline || form == Form::convex;
    curve.intervals_ = std::max(
        1, is_bspline ? curve.points_ - std::min(3, curve.points_ - 1) : curve.points_ - 1);
    curve.lo_ = lo;
    curve.width_ = (hi - lo) / curve.intervals_;
    return curve;
  }
  return std::nullopt;
}

TermCurve::Value TermCurve::basis(int j, double strain) const {
  if (points_ == 1) return {1.0, 0.0, 0.0};
  const double x = (strain - lo_) / width_;
  const double inside = std::clamp(x, 0.0, static_cast<double>(intervals_));
  const int span = std::min(static_cast<int>(inside), intervals_ - 1);
  Value at;
  if (form_ == Form::bspline || form_ == Form::convex) {
    const int degree = points_ - intervals_;
    at.value = bspline(j, degree, degree, intervals_, span, inside);
    at.first = x == inside ? bspline_slope(j, degree, intervals_, span, inside) / width_ : 0.0;
    return at;
  }
  const auto weight = [j](int point) { return j == point ? 1.0 : 0.0; };
  const auto slope = [&](int point) {
    const bool is_end = point == 0 || point == points_ - 1;
    if (form_ == Form::hermite_energy && is_end &&
        points_ > 2) {  // of the parabola of three points
      const int inward = point == 0 ? 1 : -1;
      return 0.5 * inward *
             (-3.0 * weight(point) + 4.0 * weight(point + inward) - weight(point + 2 * inward));
    }
    const int lower = std::max(point - 1, 0);
    const int upper = std::min(point + 1, points_ - 1);
    return (weight(upper) - weight(lower)) / (upper - lower);
  };
  const double t = inside - span;
  const double w0 = weight(span), w1 = weight(span + 1), m0 = slope(span), m1 = slope(span + 1);
  const double c2 = 3.0 * (w1 - w0) - 2.0 * m0 - m1;
  const double c3 = 2.0 * (w0 - w1) + m0 + m1;
  at.value = w0 + t * (m0 + t * (c2 + t * c3));
  at.first = (m0 + t * (2.0 * c2 + 3.0 * t * c3)) / width_;
  at.second = (2.0 * c2 + 6.0 * t * c3) / (width_ * width_);
  if (x == inside) return at;
  if (form_ == Form::hermite) return {at.value, 0.0, 0.0};
  const double beyond = strain - (lo_ + inside * width_);  // energies keep the curvature of the end
  at.first += at.second * beyond;
  return at;
}

// The integral over [0, strain] of a piecewise cubic: two Gauss points in each piece are exact.
double TermCurve::integral(int j, double strain) const {
  const double a = std::min(0.0, strain);
  const double b = std::max(0.0, strain);
  double sum = 0.0;
  double from = a;
  for (int i = 0; i <= intervals_ + 1; ++i) {
    const double to = i <= intervals_ ? std::clamp(lo_ + i * width_, from, b) : b;
    const double half = 0.5 * (to - from);
    if (half > 0.0) {
      const double middle = 0.5 * (from + to);
      const double off = half / std::sqrt(3.0);
      sum += half * (basis(j, middle - off).value + basis(j, middle + off).value);
    }
    from = to;
  }
  return strain < 0.0 ? -sum : sum;
}

void TermCurve::stress_basis(double strain, std::vector<double>& phi) const {
  phi.assign(static_cast<std::size_t>(points_), 0.0);
  for (int j = 0; j < points_; ++j) {
    double& out = phi[static_cast<std::size_t>(j)];
    const double centre = lo_ + j * width_;
    const double z = (strain - centre) / width_;
    switch (form_) {
      case Form::linear:
        out = strain;
        break;
      case Form::constant_stress:
        out = 1.0;
        break;
      case Form::hermite:
      case Form::bspline:
        out = basis(j, strain).value * strain;
        break;
      case Form::convex:
        out = integral(j, strain);
        break;
      case Form::hermite_energy:
        out = basis(j, strain).first;
        break;
      case Form::gaussian:
        out = -z / width_ * std::exp(-0.5 * z * z);
        break;
    }
  }
}

void TermCurve::stiffness_basis(double strain, std::vector<double>& phi) const {
  phi.assign(static_cast<std::size_t>(points_), 0.0);
  for (int j = 0; j < points_; ++j) {
    double& out = phi[static_cast<std::size_t>(j)];
    const double z = (strain - (lo_ + j * width_)) / width_;
    switch (form_) {
      case Form::linear:
        out = 1.0;
        break;
      case Form::constant_stress:
        break;
      case Form::hermite:
      case Form::bspline: {
        const Value at = basis(j, strain);
        out = at.value + at.first * strain;
        break;
      }
      case Form::convex:
        out = basis(j, strain).value;
        break;
      case Form::hermite_energy:
        out = basis(j, strain).second;
        break;
      case Form::gaussian:
        out = (z * z - 1.0) / (width_ * width_) * std::exp(-0.5 * z * z);
        break;
    }
  }
}

double TermCurve::stress(const Law& law, double strain) const {
  std::vector<double> phi;
  stress_basis(strain, phi);
  double sum = 0.0;
  for (std::size_t j = 0; j < phi.size(); ++j) sum += phi[j] * law.parameters[j].value;
  return sum;
}

double TermCurve::stiffness(const Law& law, double strain) const {
  std::vector<double> phi;
  stiffness_basis(strain, phi);
  double sum = 0.0;
  for (std::size_t j = 0; j < phi.size(); ++j) sum += phi[j] * law.parameters[j].value;
  return sum;
}

double TermCurve::secant(const Law& law, double strain) const {
  return strain == 0.0 ? stiffness(law, 0.0) : stress(law, strain) / strain;
}

}  // namespace tenter::model
