// SPDX-License-Identifier: Apache-2.0
// The key `experiment` of a scene document. For the source files of this folder only.
#pragma once

#include <string_view>
#include <vector>

#include "common/base/json_node.h"
#include "common/scene/document.h"

namespace tenter::scene {

/// Refuses (BadKey) what is not well formed.
Experiment read_experiment(const JsonNode& node);

/// Clips and phases that it names are there, ids and names are unique, numbers make sense. Messages
/// begin with the path of the key.
Expected<void> check_experiment(const Scene& scene);

/// The variants of a document that has been read, each with the path of its patch in messages.
Expected<std::vector<Run>> add_variants(std::string_view json_text, std::string_view source_name,
                                        const Experiment& experiment);

}  // namespace tenter::scene
