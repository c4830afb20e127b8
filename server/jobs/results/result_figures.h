// SPDX-License-Identifier: GPL-3.0-or-later
// The curves of a result: loops with the models over the measurement, residuals against strain and
// time, transverse stretches; and the tables of residuals on every frame from which they are drawn.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/diagnosis/diagnose.h"

namespace tenter::jobs {

/// "figures" of the result document. Loading and unloading are drawn as measured, block by block,
/// never averaged; at most 150 points a block.
nlohmann::json figures_json(const diagnosis::Diagnosis& d);

}  // namespace tenter::jobs
