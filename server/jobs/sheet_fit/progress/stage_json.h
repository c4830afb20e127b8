// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of a fit as JSON, both ways: what checkpoints keep. Numbers survive to the last bit;
// what is not finite comes back as NaN.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/base/error.h"
#include "server/estimation/staged/staged_fit.h"

namespace tenter::jobs {

const char* state_word(estimation::ParameterState state);

nlohmann::json to_json(const estimation::StagedResult& result);
/// bad_input for anything that to_json does not write.
Expected<estimation::StagedResult> staged_from_json(const nlohmann::json& value);

}  // namespace tenter::jobs
