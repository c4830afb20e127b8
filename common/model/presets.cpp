// SPDX-License-Identifier: Apache-2.0
#include "common/model/presets.h"

#include "common/model/document.h"
#include "common/model/preset_texts.h"

namespace tenter::model {

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const PresetText& text : preset_texts()) names.emplace_back(text.name);
  return names;
}

Expected<std::string> preset_json(std::string_view name) {
  for (const PresetText& text : preset_texts())
    if (text.name == name) return std::string(text.json);
  std::string known;
  for (const PresetText& text : preset_texts())
    known += (known.empty() ? "" : ", ") + std::string(text.name);
  return fail(ErrorKind::not_found,
              "no model named '" + std::string(name) + "'; the shipped ones are " + known);
}

Expected<Model> preset(std::string_view name) {
  const Expected<std::string> json = preset_json(name);
  if (!json) return tl::unexpected(json.error());
  return parse_model(*json, "preset " + std::string(name));
}

}  // namespace tenter::model
