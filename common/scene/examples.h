// SPDX-License-Identifier: Apache-2.0
// The scenes that come with Tenter, by name: documents under examples/, to run and to begin with.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"

namespace tenter::scene {

struct ExampleText {
  std::string_view name;
  std::string_view json;
};

/// In the order in which they are listed to a user; the source file is generated.
const std::vector<ExampleText>& example_texts();

/// The document as shipped. Unknown name: an Error that lists the known ones.
Expected<std::string> example_json(std::string_view name);

}  // namespace tenter::scene
