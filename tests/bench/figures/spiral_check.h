// SPDX-License-Identifier: GPL-3.0-or-later
// Strips of a mesh against one dimension: where does a strip of the scene come to rest that is
// unrolled with care, and where do the torque balance (thesis 5.7, estimation/friction_tests) and
// the chain of hinges of tests/twin/friction put it?
//
//   shape    of the mesh at rest: the scene as statics, one equilibrium from the wound strip, which
//            it remembers; turn of the middle line over its length
//   hinges   of the same mesh, a third of the strain of the edges across
//   balance  eps(T(s)) by StrainPoint: from flat to 3/r, then to the torque of the mesh's own shape
//   chain    a chain of 400 hinges that finds its own shape; none without friction, where it creeps
//
// A mesh's shape is softer than its hinges across say, as diagonals fold too: on square cells by up
// to a quarter of what the hinges turn, where nothing else holds them.
//
// Printed: rms curvature of each, and the rms difference of balance and shape over the shape's.
#pragma once

#include <string>

#include "common/scene/document.h"

namespace tenter::bench {

/// For every run of an unrolling scene that is wound without a pitch; the samples are those of
/// table 5.2 by the model's name. False where something fails, which is printed.
bool check_spirals(const scene::Scene& scene, const std::string& scene_text);

}  // namespace tenter::bench
