// SPDX-License-Identifier: Apache-2.0
// Going on from a diagnosis: its captures, its model and its options, with new captures beside
// them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/api/client.h"
#include "common/base/error.h"

namespace tenter::cli {

struct Continued {
  std::vector<std::string> captures;  ///< SHA-256 of what it diagnosed
  std::string model_json;             ///< its starting model
  nlohmann::json options;             ///< its options, with what it said as "continues"
};

/// Of a job by number or "last". bad_input where that is no diagnosis, or has not succeeded.
Expected<Continued> continue_from(client::Client& client, const std::string& name);

}  // namespace tenter::cli
