// SPDX-License-Identifier: Apache-2.0
// A simulated scene (schema "tenter.simulation") as one HTML page: what was simulated, the figure
// of its experiment and the numbers of every run, forces and energies at the last frame, and the
// model's parameters. Called by render_html, which is the door.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report {

inline constexpr const char* kSceneSchema = "tenter.simulation";

/// `result` has been read by parse_document.
std::string scene_page(const Json& result);

}  // namespace tenter::report
