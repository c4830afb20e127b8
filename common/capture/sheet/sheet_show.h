// SPDX-License-Identifier: Apache-2.0
// Private: the part of `show` that speaks of a sheet.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/capture/sheet/sheet.h"

namespace tenter::capture {

std::string sheet_text(const Sheet& sheet);

/// Keys: mesh, clips, cords, supports, gravity_m_s2.
nlohmann::ordered_json sheet_json(const Sheet& sheet);

}  // namespace tenter::capture
