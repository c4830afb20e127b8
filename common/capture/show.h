// SPDX-License-Identifier: Apache-2.0
// A capture in words and numbers: what it is, how it was pulled, what each channel holds. The text
// is for people, the JSON for scripts; both say where the numbers come from and whether they are
// synthetic.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/capture/capture.h"

namespace tenter::capture {

std::string show_text(const Capture& capture);

/// Keys: kind, title, synthetic, specimen, protocol, frames, runs, branches, time_s, sheet (where
/// there is one), kinematics, stresses, channels, provenance.
nlohmann::ordered_json show_json(const Capture& capture);

/// "prescribed: distance of top_pin and bottom_pin over that of the first frame of the capture"
std::string axis_in_words(const AxisState& axis);

}  // namespace tenter::capture
