// SPDX-License-Identifier: GPL-3.0-or-later
// A twin fabric as a model of the fit: the truth that a same-discretisation fit should find.
//
// Terms are those of the preset cloth_stvk: weft, warp, shear, bend_weft, bend_warp, bend_diagonal;
// a mode with several control points has the law hermite_stiffness, else linear. The diagonalised
// StVK form is exact for stretch and shear. For bending, hinges along a grid's lines have the
// strain eps = 3 K on a third of the sheet (mesh/hinges.h):
//
//   psi(K) = psi_hinge(3 K) / 3         k_hinge(eps) = k(eps / 3) / 3
//
// On a grid with both diagonals a twist K_uv turns those hinges too, by 3 K_uv each, and the
// diagonal ones by 6 K_uv, so that B_t = 3 k_diagonal + (B_u + B_v) / 4: the diagonal term gets
// what is left. (One diagonal, or alternating ones, are far too soft where B_u is many times B_v:
// the sheet crumples along its diagonals. A strip of #14 hangs 45 mm deep instead of 27.)
#pragma once

#include "common/model/model.h"
#include "tests/twin/fabrics/fabric.h"

namespace tenter::twin {

model::Model fabric_model(const Fabric& fabric);

/// What a law's strain is over the strain of the fabric's curve: 1, and 3 for bending along u or v.
double strain_scale(Mode mode);

}  // namespace tenter::twin
