// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include "server/mechanics/scene/body.h"

namespace tenter::mechanics {
namespace {

using scene::Selection;

constexpr double kClose = 1e-9;  // of the material's extent

struct Material {
  const Eigen::Matrix3Xd& places;
  int coordinates;
  Eigen::Vector3d lo, hi;
  double close_m;

  explicit Material(const SceneBody& body)
      : places(body.material_m),
        coordinates(body.coordinates),
        lo(places.rowwise().minCoeff()),
        hi(places.rowwise().maxCoeff()),
        close_m(kClose * (hi - lo).maxCoeff()) {}
};

/// "bottom_left": every word is one end of one axis.
bool on_side(const Eigen::Vector3d& place, std::string_view words, const Material& material) {
  static constexpr std::pair<std::string_view, int> kLow[] = {
      {"left", 0}, {"front", 1}, {"bottom", -1}};
  static constexpr std::pair<std::string_view, int> kHigh[] = {
      {"right", 0}, {"back", 1}, {"top", -1}};
  const int last = material.coordinates - 1;  // bottom and top: v of a sheet, z of a body
  while (!words.empty()) {
    const std::size_t end = std::min(words.find('_'), words.size());
    const std::string_view word = words.substr(0, end);
    words.remove_prefix(std::min(end + 1, words.size()));
    for (const auto& [name, axis] : kLow)
      if (word == name) {
        const int a = axis < 0 ? last : axis;
        if (place[a] > material.lo[a] + material.close_m) return false;
      }
    for (const auto& [name, axis] : kHigh)
      if (word == name) {
        const int a = axis < 0 ? last : axis;
        if (place[a] < material.hi[a] - material.close_m) return false;
      }
  }
  return true;
}

bool takes(const Selection& selection, int node, const Material& material) {
  const Eigen::Vector3d place = material.places.col(node);
  switch (selection.kind) {
    case Selection::Kind::everything:
      return true;
    case Selection::Kind::side:
      return on_side(place, selection.side, material);
    case Selection::Kind::box:
      return (place.array() >= vector3(selection.lo).array() - material.close_m).all() &&
             (place.array() <= vector3(selection.hi).array() + material.close_m).all();
    case Selection::Kind::beyond: {
      const Eigen::Vector3d direction = vector3(selection.direction).normalized();
      return (place - vector3(selection.point)).dot(direction) >= -material.close_m;
    }
    case Selection::Kind::indices:
      return std::find(selection.indices.begin(), selection.indices.end(), node) !=
             selection.indices.end();
    case Selection::Kind::any_of:
      return std::any_of(selection.parts.begin(), selection.parts.end(),
                         [&](const Selection& part) { return takes(part, node, material); });
    case Selection::Kind::without:
      return takes(selection.parts[0], node, material) &&
             !takes(selection.parts[1], node, material);
  }
  return false;
}

Expected<void> check_indices(const Selection& selection, int node_count) {
  for (const int index : selection.indices)
    if (index < 0 || index >= node_count)
      return bad_input("node " + std::to_string(index) +
                       " is chosen, but the mesh has nodes 0 to " + std::to_string(node_count - 1));
  for (const Selection& part : selection.parts)
    if (auto ok = check_indices(part, node_count); !ok) return ok;
  return {};
}

/// Triangles of the outside of a body, normals into the material.
std::vector<std::array<int, 3>> inward_faces(const SolidMesh& mesh) {
  // a face by its sorted nodes: how often it occurs, and its corners counter-clockwise from inside
  struct Face {
    int count = 0;
    std::vector<int> corners;
  };
  std::map<std::vector<int>, Face> faces;
  const auto add = [&faces](std::vector<int> corners) {
    std::vector<int> key = corners;
    std::sort(key.begin(), key.end());
    Face& face = faces[std::move(key)];
    ++face.count;
    face.corners = std::move(corners);
  };
  for (const auto& t : mesh.tetrahedra)
    for (const auto& f : {std::array{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}})
      add({t[static_cast<std::size_t>(f[0])], t[static_cast<std::size_t>(f[1])],
           t[static_cast<std::size_t>(f[2])]});
  for (const auto& h : mesh.hexahedra)
    for (const auto& f : {std::array{0, 1, 2, 3},
                          {4, 7, 6, 5},
                          {0, 4, 5, 1},
                          {1, 5, 6, 2},
                          {2, 6, 7, 3},
                          {3, 7, 4, 0}})
      add({h[static_cast<std::size_t>(f[0])], h[static_cast<std::size_t>(f[1])],
           h[static_cast<std::size_t>(f[2])], h[static_cast<std::size_t>(f[3])]});
  std::vector<std::array<int, 3>> triangles;
  for (const auto& [key, face] : faces) {
    if (face.count != 1) continue;
    const std::vector<int>& c = face.corners;
    triangles.push_back({c[0], c[1], c[2]});
    if (c.size() == 4) triangles.push_back({c[0], c[2], c[3]});
  }
  return triangles;
}

}  // namespace

Expected<std::vector<int>> select(const Selection& selection, const SceneBody& body) {
  if (auto ok = check_indices(selection, body.node_count()); !ok) return tl::unexpected(ok.error());
  const Material material(body);
  std::vector<int> nodes;
  for (int node = 0; node < body.node_count(); ++node)
    if (takes(selection, node, material)) nodes.push_back(node);
  if (nodes.empty()) return bad_input("no node of the mesh is chosen");
  return nodes;
}

std::vector<std::array<int, 3>> pressed_surface(const SceneBody& body,
                                                const std::vector<int>& nodes) {
  std::vector<bool> chosen(static_cast<std::size_t>(body.node_count()), false);
  for (const int node : nodes) chosen[static_cast<std::size_t>(node)] = true;
  std::vector<std::array<int, 3>> all;
  if (const Cloth* cloth = std::get_if<Cloth>(&body.mesh)) {
    for (int t = 0; t < cloth->mesh.triangle_count(); ++t)
      if (cloth->mesh.layer(t) == 0)
        all.push_back(cloth->mesh.triangles[static_cast<std::size_t>(t)]);
  } else {
    all = inward_faces(std::get<SolidMesh>(body.mesh));
  }
  std::erase_if(all, [&chosen](const std::array<int, 3>& t) {
    return !std::all_of(t.begin(), t.end(),
                        [&chosen](int node) { return chosen[static_cast<std::size_t>(node)]; });
  });
  return all;
}

}  // namespace tenter::mechanics
