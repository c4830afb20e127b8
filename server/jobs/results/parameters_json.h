// SPDX-License-Identifier: GPL-3.0-or-later
// "parameters" of a result: values, standard errors, intervals and how the fit left them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/fit.h"

namespace tenter::jobs {

/// Those of a model that was fitted, with their states in flat order.
nlohmann::json model_parameters_json(const model::Model& model,
                                     const std::vector<estimation::ParameterState>& states);

}  // namespace tenter::jobs
