// SPDX-License-Identifier: GPL-3.0-or-later
// What common/mesh_text reads of the files of other programs, made into a sheet.
//
//   auto read = mesh_text::read_surface_text(bytes, 1e-3);   // the file is in millimetres
//   if (!read) return tl::unexpected(read.error());
//   auto mesh = surface_mesh(*read);                         // material space and checks
//
// Material space is taken from texture coordinates (u = weft, v = warp) where every corner has one,
// else from the plane of a flat sheet.
//
// Pure; any thread.
#pragma once

#include "common/mesh_text/mesh_text.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

using mesh_text::ReadMesh;

/// Material space from texture coordinates if there are any (times metres_per_texture_unit, since
/// many programs scale them to the unit square), else from the positions. Checked.
Expected<SurfaceMesh> surface_mesh(const ReadMesh& read, double metres_per_texture_unit = 1.0);

/// The plane of a flat surface as its material space: u is the x axis of space projected on the
/// plane (y where the plane is nearly at right angles to x), v at right angles to it, so that the
/// triangles run counter-clockwise on the whole. bad_input where a node is further from the plane
/// than kFlatness of the extent.
Expected<SurfaceMesh> material_from_positions(const Eigen::Matrix3Xd& positions_m,
                                              const std::vector<std::array<int, 3>>& triangles);

inline constexpr double kFlatness = 1e-5;

}  // namespace tenter::mechanics
