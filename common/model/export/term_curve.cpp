// SPDX-License-Identifier: Apache-2.0
#include "common/model/export/term_curve.h"

#include <algorithm>
#include <cmath>

namespace tenter::model {

double TermCurve::piece_width(int piece) const {
  if (knots_.empty()) return width_;
  return knots_[static_cast<std::size_t>(piece + 1)] - knots_[static_cast<std::size_t>(piece)];
}

double TermCurve::coordinate(double strain) const {
  if (knots_.empty()) return (strain - lo_) / width_;
  int piece = 0;
  while (piece + 1 < intervals_ && strain >= knots_[static_cast<std::size_t>(piece + 1)]) ++piece;
  return piece + (strain - knots_[static_cast<std::size_t>(piece)]) / piece_width(piece);
}

double TermCurve::knot(int i, int degree) const {
  return knots_[static_cast<std::size_t>(std::clamp(i - degree, 0, intervals_))];
}

/// Cox - de Boor on clamped knots; `span` is the piece that the strain belongs to.
double TermCurve::bspline(int j, int d, int degree, int span, double strain) const {
  if (d == 0) return j == span + degree ? 1.0 : 0.0;
  const double left = knot(j + d, degree) - knot(j, degree);
  const double right = knot(j + d + 1, degree) - knot(j + 1, degree);
  double value = 0.0;
  if (left > 0.0)
    value += (strain - knot(j, degree)) / left * bspline(j, d - 1, degree, span, strain);
  if (right > 0.0)
    value +=
        (knot(j + d + 1, degree) - strain) / right * bspline(j + 1, d - 1, degree, span, strain);
  return value;
}

double TermCurve::bspline_slope(int j, int degree, int span, double strain) const {
  const double left = knot(j + degree, degree) - knot(j, degree);
  const double right = knot(j + degree + 1, degree) - knot(j + 1, degree);
  double slope = 0.0;
  if (left > 0.0) slope += degree / left * bspline(j, degree - 1, degree, span, strain);
  if (right > 0.0) slope -= degree / right * bspline(j + 1, degree - 1, degree, span, strain);
  return slope;
}

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
    curve.intervals_ =
        may_have_knots(law) ? spline_pieces(law, curve.points_) : std::max(1, curve.points_ - 1);
    curve.lo_ = lo;
    curve.width_ = (hi - lo) / curve.intervals_;
    if (may_have_knots(law)) curve.knots_ = spline_knots(law, domain);
    return curve;
  }
  return std::nullopt;
}

TermCurve::Value TermCurve::basis(int j, double strain) const {
  if (points_ == 1) return {1.0, 0.0, 0.0};
  const double x = coordinate(strain);
  const double inside = std::clamp(x, 0.0, static_cast<double>(intervals_));
  const int span = std::min(static_cast<int>(inside), intervals_ - 1);
  const double width = piece_width(span);
  Value at;
  if (form_ == Form::bspline || form_ == Form::convex) {
    const int degree = points_ - intervals_;
    const double there = std::clamp(strain, knots_.front(), knots_.back());
    at.value = bspline(j, degree, degree, span, there);
    at.first = x == inside ? bspline_slope(j, degree, span, there) : 0.0;
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
    if (knots_.empty()) return (weight(upper) - weight(lower)) / (upper - lower);
    return width * (weight(upper) - weight(lower)) /
           (knots_[static_cast<std::size_t>(upper)] - knots_[static_cast<std::size_t>(lower)]);
  };
  const double t = inside - span;
  const double w0 = weight(span), w1 = weight(span + 1), m0 = slope(span), m1 = slope(span + 1);
  const double c2 = 3.0 * (w1 - w0) - 2.0 * m0 - m1;
  const double c3 = 2.0 * (w0 - w1) + m0 + m1;
  at.value = w0 + t * (m0 + t * (c2 + t * c3));
  at.first = (m0 + t * (2.0 * c2 + 3.0 * t * c3)) / width;
  at.second = (2.0 * c2 + 6.0 * t * c3) / (width * width);
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
    const double end = knots_.empty()    ? lo_ + i * width_
                       : i <= intervals_ ? knots_[static_cast<std::size_t>(i)]
                                         : b;
    const double to = i <= intervals_ ? std::clamp(end, from, b) : b;
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
