// SPDX-License-Identifier: GPL-3.0-or-later
// Which points lie beside ones that a frame did not see? What hides a point is seen by the patches
// of its neighbours too, and draws them towards the camera.
//
// A point is hidden in a frame that measured no coordinate of it, unless it lies on nodes that are
// held or clamped there; so are the frame's hidden_m, which are no channels. Neighbours are within
// 1.5 times the sequence's spacing in the material: of a square grid the eight around.
//
// Pure; seen points x hidden ones.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

/// Median distance to the nearest other place; 0 where there are fewer than two.
double spacing_m(const std::vector<Eigen::Vector2d>& places_m);

/// [frame][point]: seen, but a neighbour is hidden.
std::vector<std::vector<bool>> beside_hidden(const Sequence& sequence);

}  // namespace tenter::estimation
