// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies from the files of other programs: Gmsh MSH in ascii, version 2.2 or 4.1, from a byte
// string that the caller has read.
//
// Why MSH: Gmsh is the free mesher that labs have, it reads CAD and segmented surfaces and writes
// MSH by default; 2.2 is also what fTetWild, CGAL's examples and most converters (meshio) write, so
// files of TetGen, Abaqus or VTK come in through one command.
//
//   auto read = read_msh(bytes, 1e-3);      // the file is in millimetres
//
// Tetrahedra of 4 and hexahedra of 8 nodes are read; points, lines, triangles and quadrilaterals of
// the boundary are passed over, as are other sections; any other kind of element is an error. Nodes
// that no volume element uses (points of the geometry) are left out. Errors (bad_input) name the
// line. Memory and time are linear in the bytes given (up to a sort), whatever counts they claim.
// Pure; any thread.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "server/mechanics/mesh/solid_mesh.h"

namespace tenter::mechanics {

struct ReadSolid {
  SolidMesh mesh;                      ///< passes check()
  std::vector<std::int64_t> node_tag;  ///< of each node: its number in the file
};

Expected<ReadSolid> read_msh(std::string_view text, double metres_per_unit = 1.0);

}  // namespace tenter::mechanics
