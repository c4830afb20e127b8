// SPDX-License-Identifier: GPL-3.0-or-later
// Which points lie beside ones that a frame did not see? What hides a point is seen by the patches
// of its neighbours too, and draws them towards the camera.
//
// A point is hidden in a frame that measured no coordinate of it, unless it lies on nodes that are
// held or clamped there. Neighbours are points within 1.5 times the spacing in the material, which
// is the median distance to the nearest other point: of a square grid the eight around.
//
// Pure; quadratic in the points.
#pragma once

#include <vector>

#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

/// [frame][point]: seen, but a neighbour is hidden.
std::vector<std::vector<bool>> beside_hidden(const Sequence& sequence);

}  // namespace tenter::estimation
