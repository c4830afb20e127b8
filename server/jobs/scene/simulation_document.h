// SPDX-License-Identifier: GPL-3.0-or-later
// What a simulated scene leaves as result.json: one row per frame, without the mesh.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/frames/frames.h"
#include "common/model/model.h"
#include "common/scene/scene.h"
#include "server/mechanics/scene/run.h"

namespace tenter::jobs {

/// Schema "tenter.simulation", version 1; README.md lists the keys.
nlohmann::json simulation_document(const scene::Scene& scene, const model::Model& model,
                                   const frames::FrameSet& frames, const mechanics::SceneEnd& end);

}  // namespace tenter::jobs
