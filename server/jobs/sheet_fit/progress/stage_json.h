// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of a fit, and outcomes of random starts, as JSON, both ways: what checkpoints keep.
// Numbers survive to the last bit; what is not finite comes back as NaN.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "common/base/error.h"
#include "server/estimation/staged/staged_fit.h"
#include "server/estimation/staged/start/multi_start.h"

namespace tenter::jobs {

const char* state_word(estimation::ParameterState state);

nlohmann::json to_json(const estimation::StagedResult& result);
/// bad_input for anything that to_json does not write.
Expected<estimation::StagedResult> staged_from_json(const nlohmann::json& value);

nlohmann::json to_json(const std::vector<estimation::StartOutcome>& outcomes);
Expected<std::vector<estimation::StartOutcome>> outcomes_from_json(const nlohmann::json& value);

}  // namespace tenter::jobs
