// SPDX-License-Identifier: GPL-3.0-or-later
// Hinges: the interior edges of a mesh, over which discrete shells bend (thesis (3.5)).
//
//   eps_b = (theta - theta_0) / h0     h0 = (h_left + h_right) / 6   a third of the mean height
//   energy = sum of area * density(eps_b)          area = l0 * h0   (the rectangle of thesis 3.3.1)
//
// The strain 3 (theta - theta_0) / h of 5.2.1, with h the mean height, is the same number. Since
// l0 * h = twice the mean area of the two triangles, area is a third of their summed area: over all
// edges these would add up to the sheet, less the boundary, over which nothing bends. In a
// homogeneous bend along a grid's axis eps_b is 3 curvatures, on hinges that stand for a third of
// the sheet.
//
// Elsewhere the cut of the mesh counts (psi of one k for all directions, over what a cylinder of
// the same curvature should take): a grid of one diagonal takes 1 at 0, 90 and 135 degrees and 3 at
// 45, with both diagonals 1 along the axes and 2 between, irregular meshes about 1.05 whatever
// their fineness. Strips that are free to twist are softer: 0.8 with one diagonal and with
// alternating ones, 1 with both (tests/server/mechanics/equilibrium/bending).
//
// Sign: theta > 0 where the corners leave the edge against the normals of the triangles (a ridge
// seen from the normals' side); dihedral_angle() is that definition.
//
//   for (const Hinge& h : hinges(mesh)) energy += h.area_m2 * density(strain(h, positions));
//
// A mesh of two layers has the hinges of each, with the layer's share of the area. Pure; call once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "server/mechanics/mesh/direction.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

struct Hinge {
  std::array<int, 4>
      nodes;              ///< edge (0, 1), corner of the triangle left of it (2), right of it (3)
  double rest_length_m;   ///< l0 of the edge
  double height_m;        ///< h0
  double area_m2;         ///< l0 * h0 (times the mean weight of the triangles)
  Direction bend;         ///< in which the cloth bends: at right angles to the edge
  double rest_angle_rad;  ///< theta_0
};

/// Hinges of a sheet that is flat at rest, sorted by (layer, nodes[0], nodes[1]), nodes[0] <
/// nodes[1].
std::vector<Hinge> hinges(const SurfaceMesh& mesh);

/// The same, with the angles of a rest shape in space (one column a node, as many as the mesh has,
/// else bad_input; also where a triangle of a hinge has no area in space: its angle is undefined).
/// Lengths stay those of the material.
Expected<std::vector<Hinge>> hinges(const SurfaceMesh& mesh, const Eigen::Matrix3Xd& rest_m);

/// Signed angle between the normals of two triangles at an edge, in (-pi, pi]; the corners in the
/// order of Hinge::nodes. 0 where a triangle has no area.
double dihedral_angle(const Eigen::Vector3d& edge_from, const Eigen::Vector3d& edge_to,
                      const Eigen::Vector3d& left, const Eigen::Vector3d& right);

}  // namespace tenter::mechanics
