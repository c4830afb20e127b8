// SPDX-License-Identifier: Apache-2.0
// The result document of a simulated scene with an experiment of two runs. Made up.
#pragma once

#include <nlohmann/json.hpp>

namespace tenter::report::fixture {

nlohmann::ordered_json simulation();

}  // namespace tenter::report::fixture
