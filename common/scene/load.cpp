// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include "common/base/json_node.h"
#include "common/base/text_file.h"
#include "common/scene/document.h"

namespace tenter::scene {

namespace {

/// Meshes travel inside JSON, so their bytes must be text.
bool is_ascii(const std::string& bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code < 0x7f && (code >= 0x20 || code == '\n' || code == '\r' || code == '\t');
  });
}

}  // namespace

Expected<std::string> load_self_contained(const std::string& path) {
  const auto text = read_text_file(path, kMaxDocumentBytes);
  if (!text) return text;
  const auto scene = parse_scene(*text, path);
  if (!scene) return tl::unexpected(scene.error());
  auto document = nlohmann::ordered_json::parse(*text);
  const auto* file = std::get_if<FileMesh>(&scene->mesh);
  if (file != nullptr && file->text.empty()) {
    const std::filesystem::path beside = std::filesystem::path(path).parent_path() / file->path;
    const auto mesh = read_text_file(beside.string(), kMaxMeshBytes);
    if (!mesh) return fail(mesh.error().kind, path + ": mesh.path: " + mesh.error().message);
    if (!is_ascii(*mesh))
      return bad_input(path + ": mesh.path: " + beside.string() +
                       " is a binary file; save it as text (PLY: ascii, MSH: ascii)");
    document["mesh"].erase("path");
    document["mesh"]["format"] = file->is_msh ? "msh" : file->path.ends_with("ply") ? "ply" : "obj";
    document["mesh"]["text"] = *mesh;
  }
  return document.dump();
}

}  // namespace tenter::scene
