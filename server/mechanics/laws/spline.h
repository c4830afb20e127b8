// SPDX-License-Identifier: GPL-3.0-or-later
// Spline laws, the same curve on each strain of the measure; all are linear in their parameters.
//
//   hermite_stiffness  sigma = k(eps) eps, k a cubic Hermite spline through n control points
//                      (thesis 3.3.2), the energy its closed-form integral; one point: linear
//   bspline_stiffness  the same with a clamped cubic B-spline: k >= 0 where its coefficients are
//   convex_spline      sigma = integral of E from 0, E(eps) = sum e_j B_j(eps) >= 0: the energy
//                      is convex in the strain
//
// Pieces span the knots (model::spline_knots), even over [range_lo, range_hi] or as the document
// has them; outside, the end value of k (of E) continues. Where knots are uneven, slopes of the
// Hermite curve are the differences of its neighbours over their distance, one-sided at the ends.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class SplineLaw final : public Law {
 public:
  enum class Form { hermite_stiffness, bspline_stiffness, convex };
  /// `knots`: the ends of the pieces, rising (of one point two, which may be equal); `is_even`: by
  /// their distance alone.
  SplineLaw(Form form, int strains, int points, const std::vector<double>& knots, bool is_even);
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
  /// The stress of one basis function: the law is linear in its parameters.
  void stress_by_parameter_batch(const double* parameters, int parameter,
                                 const LawBatch& batch) const override;

 private:
  /// One basis function on one interval: value = sum_k c[k] t^k, t in [0, 1]; and the integrals of
  /// value * eps^power from the first control point to the interval's start.
  struct Piece {
    double c[4] = {0.0, 0.0, 0.0, 0.0};
    double moment[2] = {0.0, 0.0};
  };
  struct Basis {
    double value;
    double slope;
    double moment[2];  ///< integral of B(s) s^power over [0, eps]
  };
  const Piece& piece(int basis, int interval) const {
    return pieces_[static_cast<std::size_t>(basis * intervals_ + interval)];
  }
  Piece& piece(int basis, int interval) {
    return pieces_[static_cast<std::size_t>(basis * intervals_ + interval)];
  }
  /// The sum of the basis functions, weighted by the parameters, on one interval: k (or E), the
  /// stress of the convex form and the energy, as polynomials of t.
  struct Curve {
    double value[4];
    double stress[5];
    double energy[6];
  };
  /// One for each interval, and before the first and after the last the constant continuation.
  void build_curves(const double* parameters, Curve* curves) const;
  void build_hermite();
  void build_bspline();
  void build_moments();
  double end_value(int basis, bool upper) const;
  /// Integral of B(s) s^power from the first control point to the strain.
  double moment_from_lo(int basis, double strain, int power) const;
  int interval_of(double x) const;
  /// i + t in piece i, beyond the ends with the width of the last one.
  double coordinate(double strain) const {
    if (is_even_) return (strain - lo_) / width_;
    int i = 0;
    while (i + 1 < intervals_ && strain >= start(i + 1)) ++i;
    return i + (strain - start(i)) / width(i);
  }
  /// Of interval -1, 0, ..., intervals_: the first and the last are beyond the knots.
  double start(int interval) const { return starts_[static_cast<std::size_t>(interval + 1)]; }
  double width(int interval) const { return widths_[static_cast<std::size_t>(interval + 1)]; }
  Basis evaluate_basis(int basis, double strain) const;

  Form form_;
  int points_;
  int intervals_;
  double lo_;
  double width_;  ///< of one interval, where all are alike
  bool is_even_;
  std::vector<double> starts_, widths_;
  std::vector<Piece> pieces_;
  std::vector<double> moment_at_zero_[2];
};

}  // namespace tenter::mechanics
