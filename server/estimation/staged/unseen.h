// SPDX-License-Identifier: GPL-3.0-or-later
// Diagonal bending is fitted to strips that hang over an edge (thesis 3.4.2), which bend along
// themselves and hardly twist: often they do not tell it. Is a fitted curve seen, and what stands
// in for one that is not?
//
//   seen        neither flat nor without gradient nor at its upper bound, and two of its standard
//               errors are less than the larger of itself and sqrt(k_u k_v) of bending along weft
//               and warp: a value that is surely small is seen
//   stands in   a twist K_uv turns a mesh's hinges along weft and warp as well. A sheet alike in
//   all
//               directions has on a grid with both diagonals no diagonal stiffness at all (half of
//               it is B, the other half B / 4 twice: mesh/hinges.h): there it is 0. On other meshes
//               one k serves all directions: sqrt(k_u k_v), the geometric mean.
//
//   if (!is_seen(fitted, {"bend_diagonal"}, result))
//     hold_at(stand_in(fitted, mesh), {"bend_diagonal"}, fitted);
//
// Pure.
#pragma once

#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/fit.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::estimation {

/// All parameters of these terms, in a fit that the model has the values of.
bool is_seen(const model::Model& model, const std::vector<std::string>& terms,
             const FitResult& result);

/// Stiffness of diagonal bending, by the stiffnesses at rest of bending along weft and warp; 0
/// where the model lacks one of these.
double stand_in(const model::Model& model, const mechanics::SurfaceMesh& mesh);

/// Gives these terms' parameters the value, as far as their bounds go, and fixes them.
void hold_at(double value, const std::vector<std::string>& terms, model::Model& model);
/// All parameters of these terms are fixed.
bool are_held(const model::Model& model, const std::vector<std::string>& terms);

}  // namespace tenter::estimation
