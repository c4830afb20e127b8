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
#include <vector>

#include "common/base/error.h"
#include "common/scene/scene.h"

namespace tenter::scene {

inline constexpr std::size_t kMaxDocumentBytes = 4u << 20;
inline constexpr std::size_t kMaxMeshBytes = 256u << 20;
inline constexpr int kMostFrames = 100'000;

/// Parses and validates, the variants of its experiment too. `source_name` is what messages call
/// the text.
Expected<Scene> parse_scene(std::string_view json_text, std::string_view source_name);

/// What the form alone cannot say: names that are used are there and unique, numbers are finite and
/// make sense together. Messages begin with the path of the key.
Expected<void> validate(const Scene& scene);

/// One run of a scene: run 0 is the scene itself, the others are the variants of its experiment.
struct Run {
  std::string name;  ///< "" of a scene without an experiment
  Scene scene;       ///< without an experiment
  std::vector<std::string> without_laws;
};

/// Every run of a scene's document; bad_input as parse_scene, with the path of the variant.
Expected<std::vector<Run>> runs_of(std::string_view json_text, std::string_view source_name);

/// A scene file and the mesh file that it names, which is looked for beside it.
struct SceneFile {
  std::string text;  ///< the document
  Scene scene;
  std::string mesh_file;  ///< "": it names none
};

/// Reads and validates; the mesh file is there and looks like one.
Expected<SceneFile> read_scene_file(const std::string& path);

/// The document of a scene with the SHA-256 of its mesh file in place of its path: what a job
/// holds. `text` is a valid document.
std::string with_stored_mesh(const std::string& text, const std::string& sha256);

/// "obj", "ply" or "msh" by how the bytes begin; "" for anything else.
std::string_view mesh_format(std::string_view beginning);

}  // namespace tenter::scene
