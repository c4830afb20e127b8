// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of result documents: JSON has no infinity and no NaN, so that what is none of its numbers
// is null.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace tenter::jobs {

inline nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace tenter::jobs
