// SPDX-License-Identifier: GPL-3.0-or-later
// A twin fabric as a model of the fit: the truth that a same-discretisation fit should find.
//
// Terms are those of the preset cloth_stvk: weft, warp, shear, bend_weft, bend_warp, bend_diagonal;
// a mode with several control points has the law hermite_stiffness, else linear. The diagonalised
// StVK form is exact for stretch and shear. For bending, hinges of a grid of alternating diagonals
// have the strain eps = 3 K on a third of the sheet (mesh/hinges.h), and its diagonals eps = 3 (2
// K_uv), so that
//
//   psi(K) = (1/3) psi_hinge(3 K)       k_hinge(eps) = k(eps / 3) / 3
#pragma once

#include "common/model/model.h"
#include "tests/twin/fabrics/fabric.h"

namespace tenter::twin {

model::Model fabric_model(const Fabric& fabric);

/// What a law's strain is over the strain of the fabric's curve: 1, and 3 for bending.
double strain_scale(Mode mode);

}  // namespace tenter::twin
