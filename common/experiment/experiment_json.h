// SPDX-License-Identifier: Apache-2.0
// What an experiment found, for the key `experiment` of a simulation's result.json (README.md).
//
//   for (const Run& run : runs) found.push_back({run.name, &frames_of(run), ""});
//   auto document = experiment_json(*scene.experiment, found);
//
// The first of the runs is what others are compared with. Positions are rounded to a micrometre.
// bad_input begins with the path of the measure or curve. Pure; any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/frames/frames.h"
#include "common/scene/experiment.h"

namespace tenter::experiment {

struct FoundRun {
  std::string name;
  const frames::FrameSet* frames = nullptr;
  std::string reason;  ///< why it ended early; "": it did not
};

Expected<nlohmann::json> experiment_json(const scene::Experiment& experiment,
                                         const std::vector<FoundRun>& runs);

}  // namespace tenter::experiment
