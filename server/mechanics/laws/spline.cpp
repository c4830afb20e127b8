// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/spline.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

/// Cox - de Boor on the knots, the first and the last clamped, at x in the interval `inside`.
double bspline_value(const std::vector<double>& knots, int basis, int degree, int inside,
                     double x) {
  const int intervals = static_cast<int>(knots.size()) - 1;
  const auto knot = [&](int i) {
    return knots[static_cast<std::size_t>(std::clamp(i - degree, 0, intervals))];
  };
  const int span = inside + degree;
  std::vector<double> b(static_cast<std::size_t>(intervals + 2 * degree + 1), 0.0);
  b[static_cast<std::size_t>(span)] = 1.0;
  for (int d = 1; d <= degree; ++d) {
    for (int i = span - d; i <= span; ++i) {
      if (i < 0) continue;
      const double left = knot(i + d) - knot(i);
      const double right = knot(i + d + 1) - knot(i + 1);
      double value = 0.0;
      if (left > 0.0) value += (x - knot(i)) / left * b[static_cast<std::size_t>(i)];
      if (right > 0.0) value += (knot(i + d + 1) - x) / right * b[static_cast<std::size_t>(i + 1)];
      b[static_cast<std::size_t>(i)] = value;
    }
  }
  return b[static_cast<std::size_t>(basis)];
}

}  // namespace

SplineLaw::SplineLaw(Form form, int strains, int points, const std::vector<double>& knots,
                     bool is_even)
    : Law(strains, points, 0),
      form_(form),
      points_(points),
      intervals_(static_cast<int>(knots.size()) - 1),
      lo_(knots.front()),
      width_(1.0),
      is_even_(is_even) {
  if (knots.back() > knots.front()) width_ = (knots.back() - knots.front()) / intervals_;
  for (int i = -1; i <= intervals_; ++i) {
    const auto piece = static_cast<std::size_t>(std::clamp(i, 0, intervals_ - 1));
    widths_.push_back(is_even ? width_ : knots[piece + 1] - knots[piece]);
    starts_.push_back(is_even          ? lo_ + i * width_
                      : i < 0          ? lo_ - widths_.back()
                      : i < intervals_ ? knots[piece]
                                       : knots.back());
  }
  if (points == 1) {
    pieces_.resize(1);
    pieces_[0].c[0] = 1.0;
  } else if (form == Form::hermite_stiffness) {
    build_hermite();
  } else {
    build_bspline();
  }
  build_moments();
}

// k(t) = h00 k_i + h10 m_i + h01 k_(i+1) + h11 m_(i+1) with central differences for the slopes m,
// one-sided at the ends, each by the t of its interval.
void SplineLaw::build_hermite() {
  pieces_.resize(static_cast<std::size_t>(points_ * intervals_));
  const auto value_at = [](int basis, int point) { return basis == point ? 1.0 : 0.0; };
  const auto slope_at = [&](int basis, int point, int interval) {
    const int lower = std::max(point - 1, 0);
    const int upper = std::min(point + 1, points_ - 1);
    const double difference = value_at(basis, upper) - value_at(basis, lower);
    if (is_even_) return difference / (upper - lower);
    return difference * width(interval) / (start(upper) - start(lower));
  };
  for (int j = 0; j < points_; ++j) {
    for (int i = 0; i < intervals_; ++i) {
      const double k0 = value_at(j, i);
      const double k1 = value_at(j, i + 1);
      const double m0 = slope_at(j, i, i);
      const double m1 = slope_at(j, i + 1, i);
      Piece& p = piece(j, i);
      p.c[0] = k0;
      p.c[1] = m0;
      p.c[2] = -3.0 * k0 - 2.0 * m0 + 3.0 * k1 - m1;
      p.c[3] = 2.0 * k0 + m0 - 2.0 * k1 + m1;
    }
  }
}

// Each piece is a cubic: four values of the recursion give its coefficients.
void SplineLaw::build_bspline() {
  pieces_.resize(static_cast<std::size_t>(points_ * intervals_));
  const int degree = points_ - intervals_;
  std::vector<double> knots;
  for (int i = 0; i <= intervals_; ++i) knots.push_back(is_even_ ? i : start(i));
  Eigen::Matrix4d vandermonde;
  for (int r = 0; r < 4; ++r)
    for (int k = 0; k < 4; ++k) vandermonde(r, k) = std::pow(r / 3.0, k);
  const Eigen::PartialPivLU<Eigen::Matrix4d> lu(vandermonde);
  for (int j = 0; j < points_; ++j) {
    for (int i = 0; i < intervals_; ++i) {
      Eigen::Vector4d values;
      // inside the interval only, then by continuity: the recursion belongs to the interval of its
      // argument
      for (int r = 0; r < 4; ++r) {
        const double t = std::min(r / 3.0, 1.0 - 1e-15);
        const double at = is_even_ ? i + t : start(i) + t * width(i);
        values[r] = bspline_value(knots, j, degree, i, at);
      }
      const Eigen::Vector4d c = lu.solve(values);
      for (int k = 0; k < 4; ++k) piece(j, i).c[k] = c[k];
    }
  }
}

void SplineLaw::build_moments() {
  for (int j = 0; j < points_; ++j) {
    for (int power = 0; power < 2; ++power) {
      double sum = 0.0;
      for (int i = 0; i < intervals_; ++i) {
        piece(j, i).moment[power] = sum;
        for (int k = 0; k < 4; ++k) {
          const double c = piece(j, i).c[k] * width(i);
          sum += power == 0 ? c / (k + 1) : c * (start(i) / (k + 1) + width(i) / (k + 2));
        }
      }
    }
  }
  for (int power = 0; power < 2; ++power) {
    for (int j = 0; j < points_; ++j)
      moment_at_zero_[power].push_back(moment_from_lo(j, 0.0, power));
  }
}

double SplineLaw::end_value(int basis, bool upper) const {
  const Piece& p = piece(basis, upper ? intervals_ - 1 : 0);
  return upper ? p.c[0] + p.c[1] + p.c[2] + p.c[3] : p.c[0];
}

// in this order an x that is no number has a place, and gives no number
int SplineLaw::interval_of(double x) const {
  return static_cast<int>(std::max(0.0, std::min(intervals_ - 0.5, x)));
}

double SplineLaw::moment_from_lo(int basis, double strain, int power) const {
  const double x = coordinate(strain);
  const int i = interval_of(x);
  const double t = std::clamp(x - i, 0.0, 1.0);
  const Piece& p = piece(basis, i);
  double sum = p.moment[power];
  double tk = t;
  for (int k = 0; k < 4; ++k, tk *= t) {
    const double c = p.c[k] * width(i) * tk;
    sum += power == 0 ? c / (k + 1) : c * (start(i) / (k + 1) + width(i) * t / (k + 2));
  }
  // beyond the ends the end value continues
  const double end = strain < lo_ ? lo_ : start(intervals_);
  if (strain < lo_ || strain > end) {
    const double b = end_value(basis, strain > lo_);
    sum += power == 0 ? b * (strain - end) : 0.5 * b * (strain * strain - end * end);
  }
  return sum;
}

SplineLaw::Basis SplineLaw::evaluate_basis(int basis, double strain) const {
  const double x = coordinate(strain);
  const int i = interval_of(x);
  const double t = std::clamp(x - i, 0.0, 1.0);
  const Piece& p = piece(basis, i);
  Basis b;
  b.value = p.c[0] + t * (p.c[1] + t * (p.c[2] + t * p.c[3]));
  const bool inside = x >= 0.0 && x <= intervals_;
  b.slope = inside ? (p.c[1] + t * (2.0 * p.c[2] + 3.0 * t * p.c[3])) / width(i) : 0.0;
  for (int power = 0; power < 2; ++power) {
    b.moment[power] = moment_from_lo(basis, strain, power) -
                      moment_at_zero_[power][static_cast<std::size_t>(basis)];
  }
  return b;
}

void SplineLaw::evaluate(const LawInput& in, LawOutput& out) const {
  for (int i = 0; i < strain_count(); ++i) {
    const double e = in.strain[i];
    for (int j = 0; j < points_; ++j) {
      const Basis b = evaluate_basis(j, e);
      const double p = in.parameters[j];
      double stress_by_p = 0.0;
      if (form_ == Form::convex) {
        stress_by_p = b.moment[0];
        out.energy += p * (e * b.moment[0] - b.moment[1]);
        out.tangent[i][i] += p * b.value;
      } else {
        stress_by_p = b.value * e;
        out.energy += p * b.moment[1];
        out.tangent[i][i] += p * (b.value + b.slope * e);
      }
      out.stress[i] += p * stress_by_p;
      out.stress_by_parameter[i][j] = stress_by_p;
    }
  }
}

}  // namespace tenter::mechanics
