// SPDX-License-Identifier: Apache-2.0
// A scene document between its JSON text and memory: read, check, make fit for sending.
//
//   Expected<Scene> scene = parse_scene(text, "hanging.scene.json");
//   // error: "hanging.scene.json: mesh.nodes_u: must be a number, not a string"
//
// The form is in README.md and tenter.scene.schema.json. Unknown and repeated keys are errors; what
// is left out has the default of scene.h.
#pragma once

#include <string>
#include <string_view>

#include "common/base/error.h"
#include "common/scene/scene.h"

namespace tenter::scene {

inline constexpr std::size_t kMaxDocumentBytes = 4u << 20;
inline constexpr std::size_t kMaxMeshBytes = 2u << 20;
inline constexpr int kMostFrames = 100'000;

/// Parses and validates. `source_name` is what messages call the text.
Expected<Scene> parse_scene(std::string_view json_text, std::string_view source_name);

/// What the form alone cannot say: names that are used are there and unique, numbers are finite and
/// make sense together. Messages begin with the path of the key.
Expected<void> validate(const Scene& scene);

/// The document of a scene file with the mesh file that it names put into it, so that it needs
/// nothing else; validated. The mesh is looked for beside the scene.
Expected<std::string> load_self_contained(const std::string& path);

}  // namespace tenter::scene
