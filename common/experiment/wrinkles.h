// SPDX-License-Identifier: Apache-2.0
// The wrinkles of a sheet as a height at every node, and whether two of its states have the same
// ones in the same places (thesis 5.5: persistent, preferred, history-dependent wrinkles).
//
//   w_i = (x_i - X_i) . N_i                     X: a state without wrinkles, N its normal
//   wrinkle_i = w_i - sum_j g_ij w_j            g_ij ~ A_j exp(-|X_i - X_j|^2 / (2 width^2))
//   height = sqrt(sum A w^2 / sum A)            w: the wrinkles, A: areas of the nodes at X
//   likeness = sum A w w' / sqrt(sum A w^2 sum A w'^2)
//
// Likeness is 1 for the same wrinkles in place, about 0 for wrinkles elsewhere, -1 for ridges in
// place of valleys. What is long is shape, not wrinkles: of a wave 1 - exp(-(2 pi width / length)^2
// / 2) is left, 0.99 of two widths, 0.71 of four, 0.42 of six, 0.18 of ten. Of measured points on
// an open sheet: server/estimation/sequences/folds.
//
//   auto first = wrinkles_of(triangles, start_m, cycle_1_m, 0.02);
//   auto second = wrinkles_of(triangles, start_m, cycle_2_m, 0.02);
//   auto alike = likeness(*first, *second);
//
// Pure; O(nodes^2); any thread.
#pragma once

#include <span>
#include <vector>

#include "common/base/error.h"

namespace tenter::experiment {

struct Wrinkles {
  std::vector<double> height_m;  ///< one a node, towards the normals of the triangles
  std::vector<double> area_m2;   ///< a third of each triangle to each corner
};

/// `triangles`: three nodes each; positions: three numbers a node. bad_input: lists that do not
/// match, a number that is none, a width that is not positive, a node about which `smooth_m` has no
/// area or no normal.
Expected<Wrinkles> wrinkles_of(std::span<const int> triangles, std::span<const double> smooth_m,
                               std::span<const double> position_m, double width_m);

/// Root of the mean square over the area, m.
double height_m(const Wrinkles& wrinkles);

/// bad_input: of different meshes, or one without any wrinkle: there is nothing to be like.
Expected<double> likeness(const Wrinkles& a, const Wrinkles& b);

}  // namespace tenter::experiment
