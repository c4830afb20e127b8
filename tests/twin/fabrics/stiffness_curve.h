// SPDX-License-Identifier: GPL-3.0-or-later
// A stiffness curve of a twin fabric: what is hidden in the captures, and what a fitted curve is
// compared with.
//
//   sigma(e) = k(e) e,   k through even control points over [lo, hi] by cubic Hermite pieces with
//   slopes by central differences (thesis 3.3.2); beyond the ends the end value continues
//
// Stretch and shear: k in N/m over Green strain. Bending: N m over curvature in 1/m. Shares nothing
// with server/.
//
//   StiffnessCurve curve{0.0, 0.03, {2500.0, 4500.0, 8000.0}};
//   CurveValue at = curve.at(0.012);         // energy density, stress, tangent
//
// Pure; no allocation in at().
#pragma once

#include <vector>

namespace tenter::twin {

struct CurveValue {
  double energy = 0.0;   ///< integral of the stress from rest
  double stress = 0.0;   ///< k e
  double tangent = 0.0;  ///< dstress/de
};

struct StiffnessCurve {
  double lo = 0.0;
  double hi = 0.0;
  std::vector<double> k;  ///< at the control points; a single one is a constant stiffness

  double stiffness(double strain) const;
  CurveValue at(double strain) const;
  double largest() const;

 private:
  /// Integral of k(s) s from lo to strain.
  double energy_from_lo(double strain) const;
  struct Piece {
    double start = 0.0, width = 0.0;
    double c[4] = {};  ///< k = sum c_i t^i, t from 0 to 1
  };
  Piece piece(int interval) const;
};

}  // namespace tenter::twin
