// SPDX-License-Identifier: GPL-3.0-or-later
// Strips of a mesh against one dimension: where does a strip of the scene come to rest that is
// unrolled with care, and where do the torque balance (thesis 5.7, estimation/friction_tests) and
// the chain of hinges of tests/twin/friction put it?
//
//   mesh     the scene as statics: one equilibrium from the wound strip, which it remembers
//   balance  eps(T(s)) by StrainPoint: from flat to 3/r, then to the torque of the mesh's own
//   shape;
//            its difference to the mesh is what hinges and triangles make of one strain
//   chain    a chain of 400 hinges that finds its own shape
//
// Printed: rms curvature of each, and the rms difference of balance and mesh over the mesh's.
#pragma once

#include <string>

#include "common/scene/document.h"

namespace tenter::bench {

/// For every run of an unrolling scene; the samples are those of table 5.2 by the model's name.
/// False where something fails, which is printed.
bool check_spirals(const scene::Scene& scene, const std::string& scene_text);

}  // namespace tenter::bench
