// SPDX-License-Identifier: GPL-3.0-or-later
// A body cut into tetrahedra (4 nodes, linear) and hexahedra (8 nodes, trilinear), thesis ch. 4.
//
// Node order of a tetrahedron: (x1 - x0) x (x2 - x0) . (x3 - x0) > 0. Of a hexahedron: 0 1 2 3
// round the bottom, counter-clockwise seen from above, 4 5 6 7 above them; reference corners
// (-1,-1,-1) (1,-1,-1) (1,1,-1) (-1,1,-1) and the same with +1. Both as in Gmsh and VTK.
//
//   auto mesh = box_hexahedra(8, 4, 4, {0.2, 0.1, 0.1});
//   const std::vector<double> mass = lumped_masses_kg(*mesh, 1050.0);
//
// Pure functions, callable from any thread; costs are linear up to a sort of the faces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/base/error.h"

namespace tenter::mechanics {

struct SolidMesh {
  Eigen::Matrix3Xd rest_m;  ///< rest position of each node
  std::vector<std::array<int, 4>> tetrahedra;
  std::vector<std::array<int, 8>> hexahedra;

  int node_count() const { return static_cast<int>(rest_m.cols()); }
};

/// An element's Jacobian (six times a tetrahedron's volume; at a corner of a hexahedron, the
/// triple product of its edges) over the cube of its longest edge must exceed this.
inline constexpr double kFlattestSolid = 1e-6;

/// The most nodes of a box.
inline constexpr int kMostBoxNodes = 4'000'000;

/// Finite nodes, indices in range, different corners, right-handed elements of positive volume (of
/// a hexahedron: positive Jacobian at its corners and at its 8 quadrature points), at most two
/// elements at a face, no node without an element. bad_input names the element, face or node.
Expected<void> check(const SolidMesh& mesh);

/// Volume of each element, tetrahedra first. They sum to the volume of the body.
std::vector<double> volumes_m3(const SolidMesh& mesh);

/// Mass of each node: the integral of its shape function (a quarter of a tetrahedron to each
/// corner; 2 x 2 x 2 Gauss points in a hexahedron, exact).
std::vector<double> lumped_masses_kg(const SolidMesh& mesh, double density_kg_m3);

/// The same shape of distribution, scaled to the weighed mass of the body.
std::vector<double> lumped_masses_of_total_kg(const SolidMesh& mesh, double total_mass_kg);

/// A box with a corner at 0, cut into nx x ny x nz cells; node (i, j, k) has index (k (ny + 1) + j)
/// (nx + 1) + i. Tetrahedra: six to a cell about its main diagonal (Kuhn), which fit together from
/// cell to cell. bad_input for no cells, more than kMostBoxNodes nodes, a size that is not
/// positive, or cells too slender.
Expected<SolidMesh> box_tetrahedra(int nx, int ny, int nz, const Eigen::Vector3d& size_m);
Expected<SolidMesh> box_hexahedra(int nx, int ny, int nz, const Eigen::Vector3d& size_m);

}  // namespace tenter::mechanics
