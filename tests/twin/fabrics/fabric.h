// SPDX-License-Identifier: GPL-3.0-or-later
// The twin fabrics: four cloths that behave as the thesis says of its samples (3.5), and a second
// specimen of each.
//
//   #4 satin      stretch equal both ways and very stiff: its greatest stiffness is 250 times that
//                 of #12; bends easily
//   #12 knit      compliant, nearly linear
//   #14 denim     stiff, bending 33 : 1, ten times stiffer in shear than any other
//   #18 wool      stretch 10 : 1, bending 13 : 1
//
// Masses are those of Table 3.1, loading-to-unloading ratios lie between 1.4 and 1.8. Absolute
// values are chosen: pulled to its limit, a square of 100 mm needs 2 to 30 N (the residuals of
// Tables A.1 to A.4 are the width of loops of that size), and stretch and bending lie about the
// fitted values of Wang et al. 2011 for garment fabrics.
//
// The energy per area is that of a thin sheet without coupling,
//
//   psi = psi_u(E_uu) + psi_v(E_vv) + psi_s(w_u . w_v)
//       + psi_bu(K_uu) + psi_bv(K_vv) + psi_bt(2 K_uv)
//
// with Green strains (thesis (3.3)) and K_ab = x,ab . n by material coordinates, each psi of its
// curve.
//
// Every mode that twists has one stiffness, above a quarter of B_u + B_v: less, a hinge mesh cannot
// say.
//
// Data; shares nothing with server/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/twin/fabrics/laws/hidden_laws.h"
#include "tests/twin/fabrics/stiffness_curve.h"

namespace tenter::twin {

enum class Mode { stretch_u, stretch_v, shear, bend_u, bend_v, bend_twist };
inline constexpr int kModes = 6;

/// Friction within a mode: it follows the stress with a share of its size, against the motion.
struct Loop {
  double ratio = 1.0;  ///< stress of loading over that of unloading, once the branch is reached
  double reach = 1.0;  ///< strain over which the branch is reached after a turn
};

/// How far the protocols go with this fabric.
struct Limits {
  double stretch_u = 0.0, stretch_v = 0.0;  ///< relative elongation between the bars
  double shear = 0.0;                       ///< sine of the angle of the picture frame
  double frame_u = 0.0, frame_v = 0.0;      ///< stretch of the picture frame before it shears
  double complex_shear = 0.0;               ///< sideways motion over free length
  double corner_m = 0.0;                    ///< way of a corner
};

struct Fabric {
  std::string id;    ///< "4", "12", "14", "18"; the second specimens "4.2" and so on
  std::string name;  ///< "cotton satin"
  double side_m = 0.1;
  double mass_kg = 0.0;
  std::array<StiffnessCurve, kModes> curves;  ///< N/m by strain; N m by curvature
  std::array<Loop, kModes> loops;
  Limits limits;
  HiddenLaws hidden = {};  ///< nothing, in the fabrics of the thesis

  const StiffnessCurve& curve(Mode mode) const { return curves[static_cast<std::size_t>(mode)]; }
};

/// In the order of the thesis, first specimens first.
std::vector<std::string> fabric_ids();

/// One of fabric_ids(); any other id is a programming error and aborts.
Fabric fabric(const std::string& id);

/// The same cloth without friction: every loop closed.
Fabric without_friction(Fabric fabric);

}  // namespace tenter::twin
