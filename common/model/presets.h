// SPDX-License-Identifier: Apache-2.0
// The models that come with Tenter, by name: the five membrane models of the thesis, the three
// cloth models with bending, their spline variants, and four solids. Each is a document under
// presets/; values are neutral starting points for a fit, not measurements.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::model {

/// In the order in which they are listed to a user.
std::vector<std::string> preset_names();

/// Unknown name: an Error that lists the known ones.
Expected<Model> preset(std::string_view name);

/// The document as shipped, for `tenter model show`.
Expected<std::string> preset_json(std::string_view name);

}  // namespace tenter::model
