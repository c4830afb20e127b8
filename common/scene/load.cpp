// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <filesystem>

#include "common/base/json_node.h"
#include "common/base/text_file.h"
#include "common/scene/document.h"

namespace tenter::scene {

namespace {

using Json = nlohmann::ordered_json;

/// A line of an OBJ file begins with one of its keywords.
bool is_obj_line(std::string_view line) {
  static constexpr std::array<std::string_view, 10> kWords = {"v", "vt", "vn", "f",      "o",
                                                              "g", "s",  "l",  "mtllib", "usemtl"};
  const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
  return word.size() < line.size() && std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

}  // namespace

std::string_view mesh_format(std::string_view beginning) {
  if (beginning.starts_with("ply\n") || beginning.starts_with("ply\r")) return "ply";
  if (beginning.starts_with("$MeshFormat")) return "msh";
  for (std::size_t at = 0; at < beginning.size();) {
    const std::size_t end = std::min(beginning.find('\n', at), beginning.size());
    const std::string_view line = beginning.substr(at, end - at);
    at = end + 1;
    if (line.empty() || line == "\r" || line.starts_with('#')) continue;
    return is_obj_line(line) ? "obj" : "";
  }
  return "";
}

Expected<SceneFile> read_scene_file(const std::string& path) {
  auto text = read_text_file(path, kMaxDocumentBytes);
  if (!text) return tl::unexpected(text.error());
  auto scene = parse_scene(*text, path);
  if (!scene) return tl::unexpected(scene.error());
  SceneFile file{std::move(*text), std::move(*scene), ""};
  const auto* mesh = std::get_if<FileMesh>(&file.scene.mesh);
  if (mesh == nullptr || mesh->path.empty()) return file;
  file.mesh_file = (std::filesystem::path(path).parent_path() / mesh->path).string();
  const auto bytes = read_text_file(file.mesh_file, kMaxMeshBytes);
  if (!bytes) return fail(bytes.error().kind, path + ": mesh.path: " + bytes.error().message);
  const std::string_view format = mesh_format(*bytes);
  if (format.empty() || (format == "msh") != mesh->is_msh)
    return bad_input(path + ": mesh.path: " + file.mesh_file + " does not begin like a file of " +
                     (mesh->is_msh ? "Gmsh (MSH)" : "OBJ or PLY"));
  return file;
}

std::string with_stored_mesh(const std::string& text, const std::string& sha256) {
  Json document = Json::parse(text);
  Json& mesh = document["mesh"];
  if (!mesh.contains("format")) {
    const auto path = mesh["path"].get<std::string>();
    mesh["format"] = path.substr(path.rfind('.') + 1);
  }
  mesh.erase("path");
  mesh["sha256"] = sha256;
  return document.dump();
}

}  // namespace tenter::scene
