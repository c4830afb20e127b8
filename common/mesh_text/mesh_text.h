// SPDX-License-Identifier: Apache-2.0
// Sheets from the files of other programs: Wavefront OBJ and PLY (ascii, binary little- and
// big-endian), from a byte string that the caller has read.
//
//   auto read = read_surface_text(bytes, 1e-3);              // the file is in millimetres
//   if (!read) return tl::unexpected(read.error());
//
// Corners of four are split from the first to the third.
//
// OBJ: v, vt, f; normals, groups, materials, lines and points are passed over, any other word is an
// error. A node with two different texture coordinates is a seam and an error: a mesh has one
// material place a node. PLY: element vertex with x, y, z and, if there, (u, v), (s, t),
// (texture_u, texture_v) or (texture_s, texture_t); element face with vertex_indices or
// vertex_index; other elements and properties are passed over.
//
// The readers are written here because what Debian has (tinyobjloader for OBJ; nothing for PLY)
// neither says the line of a fault nor bounds what a hostile count makes it allocate. Errors
// (bad_input) name the line, or element and row in binary data. Memory and time are linear in the
// bytes given, whatever counts they claim. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "common/base/error.h"

namespace tenter::mesh_text {

struct ReadMesh {
  Eigen::Matrix3Xd positions_m;
  std::vector<std::array<int, 3>> triangles;  ///< indices in range; nothing else is checked
  Eigen::Matrix2Xd texture;                   ///< (u, v) of each node as in the file; or no columns
};

Expected<ReadMesh> read_obj(std::string_view text, double metres_per_unit = 1.0);
Expected<ReadMesh> read_ply(std::string_view bytes, double metres_per_unit = 1.0);

/// PLY if it begins as one, else OBJ.
Expected<ReadMesh> read_surface_text(std::string_view bytes, double metres_per_unit = 1.0);

}  // namespace tenter::mesh_text
