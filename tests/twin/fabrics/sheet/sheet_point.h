// SPDX-License-Identifier: GPL-3.0-or-later
// Energy of a thin sheet at one point, with friction that remembers, and its derivatives by the
// derivatives of the surface.
//
//   y = (x,u  x,v  x,uu  x,vv  x,uv)     15 numbers
//   e = (E_uu, E_vv, x,u . x,v, K_uu, K_vv, 2 K_uv)      K_ab = x,ab . n,  n = x,u x x,v / |..|
//   psi = sum over modes  psi_m(e_m) + Phi_m(e_m)     and what hides (hidden_laws.h)
//
// Friction is a Dahl element whose bound follows the elastic stress, sigma_max = beta |sigma(e)|
// with beta = (ratio - 1) / (ratio + 1), so that a saturated branch has (1 + beta) sigma loading
// and (1 - beta) sigma unloading. From (e0, f0) on, moving in the direction s,
//
//   f(e) = s sigma_max(e) + (f0 - s sigma_max(e0)) exp(-|e - e0| / reach)
//   Phi(e) = s beta [Q(e) - Q(e0)]
//          + s (f0 - s sigma_max(e0)) reach (1 - exp(-|e - e0| / reach)),   Q(e) = sign(e) psi_m(e)
//
// so a step is the minimum of an energy. Shares nothing with server/. Pure; nothing allocates.
#pragma once

#include <Eigen/Core>

#include "tests/twin/fabrics/fabric.h"

namespace tenter::twin {

using SurfaceVector = Eigen::Matrix<double, 15, 1>;
using SurfaceMatrix = Eigen::Matrix<double, 15, 15>;
using Strains = Eigen::Matrix<double, kModes, 1>;

/// Strain and friction stress of every mode where the step begins; zero where never strained.
struct PointHistory {
  Strains strain = Strains::Zero();
  Strains friction = Strains::Zero();
  LawHistory laws = {};
  double stiffer = 1.0;  ///< stretch, where the point lies (HiddenLaws::stiffer_at)
  double step_s = 0.0;   ///< duration of the step that goes on from here
};

struct PointEnergy {
  double energy = 0.0;     ///< J/m^2, friction counted from the start of the step
  SurfaceVector gradient;  ///< by y
  SurfaceMatrix hessian;   ///< by y, where wanted
};

Strains strains_at(const SurfaceVector& y);

/// One mode at a strain: elastic and friction together.
CurveValue mode_at(const Fabric& fabric, int mode, const PointHistory& history, double strain);

/// `convex_share`: 0 the exact second derivative, 1 without whatever may make it negative.
void evaluate_point(const Fabric& fabric, const PointHistory& history, const SurfaceVector& y,
                    bool wants_hessian, double convex_share, PointEnergy& out);

/// The history at the end of a step that arrived at y.
PointHistory advance(const Fabric& fabric, const PointHistory& history, const SurfaceVector& y);

}  // namespace tenter::twin
