// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ. Faces may name nodes that come later in the text, so they are kept as written and
// resolved at the end; a negative index counts back from the last one before the face.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

#include "common/mesh_text/mesh_text.h"
#include "common/mesh_text/words.h"

namespace tenter::mesh_text {

namespace {

constexpr std::array<std::string_view, 14> kPassedOver = {
    "vn", "vp", "g",  "o",     "s",        "usemtl",   "mtllib",
    "l",  "p",  "mg", "bevel", "c_interp", "d_interp", "lod"};

struct Corner {
  std::int64_t node = 0;     ///< from 1; 0 = none
  std::int64_t texture = 0;  ///< from 1; 0 = none
};

struct Face {
  std::size_t line = 0;
  std::size_t count = 0;
  std::array<Corner, 4> corners;
};

struct Obj {
  std::vector<Eigen::Vector3d> nodes;
  std::vector<Eigen::Vector2d> textures;
  std::vector<Face> faces;
};

tl::unexpected<Error> fail_at(std::size_t line, const std::string& reason) {
  return bad_input("OBJ, line " + std::to_string(line) + ": " + reason);
}

/// `least` numbers at least, the first of them into `out`.
Expected<void> read_numbers(const Lines& lines, Words& words, int least, int most, double* out) {
  for (int k = 0; k < most; ++k) {
    const std::string_view word = words.next();
    if (word.empty() && k >= least) return {};
    if (word.empty())
      return lines.fail("OBJ", std::to_string(k) + " numbers where at least " +
                                   std::to_string(least) + " are needed");
    if (!to_number(word, out[k]))
      return lines.fail("OBJ", quoted(word) + " is not a finite number");
  }
  return {};
}

/// An index as written to one from 1; 0 if it points outside what came before.
std::int64_t absolute(std::int64_t index, std::size_t so_far) {
  if (index >= 0) return index;
  const std::int64_t back = static_cast<std::int64_t>(so_far) + 1;
  return index < -back ? 0 : std::max<std::int64_t>(0, back + index);
}

/// node, node/texture, node//normal or node/texture/normal.
Expected<Corner> read_corner(const Lines& lines, std::string_view word, const Obj& obj) {
  Corner corner;
  const std::size_t slash = word.find('/');
  if (!to_integer(word.substr(0, slash), corner.node))
    return lines.fail("OBJ", "face corner " + quoted(word) + " does not begin with an index");
  corner.node = absolute(corner.node, obj.nodes.size());
  if (corner.node == 0) return lines.fail("OBJ", "face corner " + quoted(word) + " names no node");
  if (slash == std::string_view::npos) return corner;
  const std::string_view rest = word.substr(slash + 1);
  const std::string_view texture = rest.substr(0, rest.find('/'));
  if (texture.empty()) return corner;
  if (!to_integer(texture, corner.texture))
    return lines.fail("OBJ", "face corner " + quoted(word) + " has no texture index");
  corner.texture = absolute(corner.texture, obj.textures.size());
  if (corner.texture == 0)
    return lines.fail("OBJ", "face corner " + quoted(word) + " names no texture coordinate");
  return corner;
}

Expected<void> read_face(const Lines& lines, Words& words, Obj& obj) {
  Face face;
  face.line = lines.number();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (face.count == 4) return lines.fail("OBJ", "a face of more than 4 corners");
    const Expected<Corner> corner = read_corner(lines, word, obj);
    if (!corner) return tl::unexpected(corner.error());
    face.corners[face.count++] = *corner;
  }
  if (face.count < 3)
    return lines.fail("OBJ", "a face of " + std::to_string(face.count) + " corners");
  obj.faces.push_back(face);
  return {};
}

Expected<void> read_line(const Lines& lines, Obj& obj) {
  Words words(lines.line().substr(0, lines.line().find('#')));
  const std::string_view keyword = words.next();
  if (keyword.empty()) return {};
  if (keyword == "f") return read_face(lines, words, obj);
  if (keyword == "v") {
    double x[3] = {};
    if (auto read = read_numbers(lines, words, 3, 3, x); !read) return read;
    obj.nodes.emplace_back(x[0], x[1], x[2]);
    return {};
  }
  if (keyword == "vt") {
    double x[2] = {};
    if (auto read = read_numbers(lines, words, 1, 2, x); !read) return read;
    obj.textures.emplace_back(x[0], x[1]);
    return {};
  }
  if (std::find(kPassedOver.begin(), kPassedOver.end(), keyword) == kPassedOver.end())
    return lines.fail("OBJ", "unknown word " + quoted(keyword));
  return {};
}

/// Texture coordinates of the corners to the nodes; one place a node.
Expected<void> place_textures(const Obj& obj, ReadMesh& mesh) {
  const bool wanted = std::any_of(obj.faces.begin(), obj.faces.end(),
                                  [](const Face& face) { return face.corners[0].texture != 0; });
  if (!wanted) {
    for (const Face& face : obj.faces)
      for (std::size_t k = 0; k < face.count; ++k)
        if (face.corners[k].texture != 0)
          return fail_at(face.line, "some corners have texture coordinates, some have none");
    return {};
  }
  mesh.texture.setZero(2, mesh.positions_m.cols());
  std::vector<std::int64_t> given(obj.nodes.size(), 0);
  for (const Face& face : obj.faces)
    for (std::size_t k = 0; k < face.count; ++k) {
      const Corner& corner = face.corners[k];
      if (corner.texture == 0)
        return fail_at(face.line, "some corners have texture coordinates, some have none");
      if (corner.texture > static_cast<std::int64_t>(obj.textures.size()))
        return fail_at(face.line,
                       "there is no texture coordinate " + std::to_string(corner.texture));
      const Eigen::Vector2d& place = obj.textures[static_cast<std::size_t>(corner.texture - 1)];
      std::int64_t& before = given[static_cast<std::size_t>(corner.node - 1)];
      if (before != 0 && obj.textures[static_cast<std::size_t>(before - 1)] != place)
        return fail_at(face.line,
                       "node " + std::to_string(corner.node) +
                           " has two texture coordinates: a seam, where the mesh must be "
                           "cut into two nodes");
      before = corner.texture;
      mesh.texture.col(corner.node - 1) = place;
    }
  return {};
}

}  // namespace

Expected<ReadMesh> read_obj(std::string_view bytes, double metres_per_unit) {
  Obj obj;
  Lines lines(bytes);
  while (lines.next())
    if (auto read = read_line(lines, obj); !read) return tl::unexpected(read.error());
  if (obj.nodes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return bad_input("OBJ: more nodes than an index can name");
  if (obj.faces.empty()) return bad_input("OBJ: no faces");

  ReadMesh mesh;
  mesh.positions_m.resize(3, static_cast<Eigen::Index>(obj.nodes.size()));
  for (std::size_t n = 0; n < obj.nodes.size(); ++n)
    mesh.positions_m.col(static_cast<Eigen::Index>(n)) = metres_per_unit * obj.nodes[n];
  for (const Face& face : obj.faces) {
    std::array<int, 4> node{};
    for (std::size_t k = 0; k < face.count; ++k) {
      if (face.corners[k].node > static_cast<std::int64_t>(obj.nodes.size()))
        return fail_at(face.line, "there is no node " + std::to_string(face.corners[k].node));
      node[k] = static_cast<int>(face.corners[k].node - 1);
    }
    mesh.triangles.push_back({node[0], node[1], node[2]});
    if (face.count == 4) mesh.triangles.push_back({node[0], node[2], node[3]});
  }
  if (auto placed = place_textures(obj, mesh); !placed) return tl::unexpected(placed.error());
  return mesh;
}

}  // namespace tenter::mesh_text
