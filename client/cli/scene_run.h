// SPDX-License-Identifier: Apache-2.0
// `simulate --scene`: a scene and a model go to the server, frames come back.
#pragma once

#include <string>
#include <vector>

#include "client/cli/context.h"
#include "client/cli/submit.h"
#include "common/base/error.h"
#include "common/model/model.h"
#include "common/scene/document.h"

namespace tenter::cli {

struct SceneJob {
  std::string scene;  ///< shipped scene or file
  std::string model;  ///< preset or file; "": the scene's, else cloth_stvk or solid_neo_hookean
  std::vector<std::string> sets;  ///< "term.parameter=value"
  SubmitOptions submit;
  bool detach = false;
  std::string figure;  ///< SVG of the scene's experiment; "": none
  std::string report;  ///< HTML page; "": none
  std::string output;  ///< folder for result.json, frames.h5 and frames.xdmf; "": nothing is kept
};

/// A walk that ends before its last frame is an Error (job_failed) with the reason, after what was
/// reached has been written and shown.
Expected<void> run_scene(Context& context, const SceneJob& job);

/// A shipped scene by name, or a scene document by file.
Expected<scene::SceneFile> load_scene(const std::string& name_or_file);

/// "weft.k=80" put into a model.
Expected<void> set_parameter(model::Model& model, const std::string& assignment);

}  // namespace tenter::cli
