// SPDX-License-Identifier: GPL-3.0-or-later
// Elements of a mesh, with everything that positions do not change: shape gradients, areas,
// volumes.
//
//   TriangleElements cloth = triangle_elements(mesh);
//   NodeMatrix matrix(mesh.node_count(), coupled_nodes(cloth));
//   cloth.slots = block_slots(matrix, cloth.nodes);
//
// Meshes must have passed check(). An empty list gives elements of count 0. Pure; call once.
#pragma once

#include <utility>
#include <vector>

#include "server/mechanics/elements/gradient_elements.h"
#include "server/mechanics/elements/hinge_elements.h"
#include "server/mechanics/mesh/hinges.h"
#include "server/mechanics/mesh/solid_mesh.h"
#include "server/mechanics/mesh/springs.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

/// F = (x_b - x_a)/l0, so that C_00 = (l/l0)^2; the measure is the spring's area.
EdgeElements edge_elements(const std::vector<Spring>& springs);

/// F = (w_u w_v) of thesis (3.2); the measure is the triangle's area times its weight.
TriangleElements triangle_elements(const SurfaceMesh& mesh);

HingeElements hinge_elements(const std::vector<Hinge>& hinges);

/// One quadrature point; the measure is the volume.
TetrahedronElements tetrahedron_elements(const SolidMesh& mesh);

/// Eight Gauss points a hexahedron, in its corners' order; the measure is det J (weight 1).
HexahedronPoints hexahedron_points(const SolidMesh& mesh);

/// Rest positions of those Gauss points, one a column.
Eigen::Matrix3Xd hexahedron_point_places_m(const SolidMesh& mesh);

/// Every pair of corners of every element, for NodeMatrix.
template <class Elements>
std::vector<std::pair<int, int>> coupled_nodes(const Elements& elements) {
  std::vector<std::pair<int, int>> pairs;
  for (const auto& nodes : elements.nodes)
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) pairs.emplace_back(nodes[a], nodes[b]);
  return pairs;
}

}  // namespace tenter::mechanics
