// SPDX-License-Identifier: GPL-3.0-or-later
// A small sequence that every sensor correction of sheets shows on, and models that have one.
#pragma once

#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation::testing {

/// 6 x 6 nodes, hung between two bars of which one moves out, up, back and on, eight frames with
/// uneven times. Channels "pull" and "lift" are of the second bar, "hold" of the first. Nine points
/// in a square; the middle one hides in two frames. What is measured is zero.
Sequence six_by_six(const std::string& name);

/// cloth_stvk, or the same with friction in shear.
model::Model sheet_model(bool remembers);
/// Adds a correction of sheets at these values, and says where its parameters begin.
int add_correction(model::Model& model, const std::string& type, const std::string& component,
                   const std::vector<double>& values, const std::string& capture = "");

}  // namespace tenter::estimation::testing
