// SPDX-License-Identifier: Apache-2.0
#include "common/scene/examples.h"

namespace tenter::scene {

Expected<std::string> example_json(std::string_view name) {
  std::string known;
  for (const ExampleText& text : example_texts()) {
    if (text.name == name) return std::string(text.json);
    known += (known.empty() ? "" : ", ") + std::string(text.name);
  }
  return fail(ErrorKind::not_found,
              "there is no shipped scene '" + std::string(name) + "'; the scenes are " + known);
}

}  // namespace tenter::scene
