// SPDX-License-Identifier: Apache-2.0
// The documents of presets/*.json as they were at build time; the source file is generated.
#pragma once

#include <string_view>
#include <vector>

namespace tenter::model {

struct PresetText {
  std::string_view name;
  std::string_view json;
};

const std::vector<PresetText>& preset_texts();

}  // namespace tenter::model
