// SPDX-License-Identifier: GPL-3.0-or-later
// Energy interpolated between control points (thesis 4.2): Psi(eps) = sum_j phi_j(eps) w_j with phi
// the cubic Hermite basis on even points over [range_lo, range_hi], slopes by central differences,
// at the ends of the parabola through three points: quadratic energies are exact, and convex ones
// possible.
//
// The energy counts from rest (Psi(0) is taken off), so a constant added to all w_j changes
// nothing; at rest it may have a stress. It is once continuously differentiable: the tangent jumps
// at control points. Beyond the ends the curvature of the end continues. Linear in its parameters.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class HermiteEnergyLaw final : public Law {
 public:
  /// points >= 2, range_lo < range_hi.
  HermiteEnergyLaw(int points, double range_lo, double range_hi);
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;

 private:
  /// Coefficients by t, 0 to 1 over an interval, of one basis function.
  struct Piece {
    double c[4];
  };
  struct Place {
    int interval;  ///< -1 and `intervals_` are the continuations
    double t;
  };
  Place place_of(double strain) const;
  const Piece& piece(int basis, int interval) const {
    return pieces_[static_cast<std::size_t>(basis * (intervals_ + 2) + interval + 1)];
  }

  int intervals_;
  double lo_;
  double width_;  ///< of one interval
  std::vector<Piece> pieces_;
  std::vector<double> at_rest_;  ///< each basis function at strain 0
};

}  // namespace tenter::mechanics
