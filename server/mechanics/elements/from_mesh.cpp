// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/elements/from_mesh.h"

#include <Eigen/LU>

#include "server/mechanics/mesh/hexahedron.h"

namespace tenter::mechanics {
namespace {

/// Of a simplex with edges as the columns of `edges`: those of corners 1..D are the rows of the
/// inverse, that of corner 0 is minus their sum.
template <int D>
std::array<std::array<double, D>, D + 1> simplex_gradients(
    const Eigen::Matrix<double, D, D>& edges) {
  const Eigen::Matrix<double, D, D> inverse = edges.inverse();
  std::array<std::array<double, D>, D + 1> gradients{};
  for (int i = 0; i < D; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    for (int a = 0; a < D; ++a) {
      gradients[static_cast<std::size_t>(a) + 1][axis] = inverse(a, i);
      gradients[0][axis] -= inverse(a, i);
    }
  }
  return gradients;
}

HexahedronCorners rest_corners(const SolidMesh& mesh, const std::array<int, 8>& nodes) {
  HexahedronCorners rest;
  for (int a = 0; a < 8; ++a) rest.col(a) = mesh.rest_m.col(nodes[static_cast<std::size_t>(a)]);
  return rest;
}

}  // namespace

EdgeElements edge_elements(const std::vector<Spring>& springs) {
  EdgeElements elements;
  for (const Spring& s : springs) {
    const double b = 1.0 / s.rest_length_m;
    elements.add({s.a, s.b}, {{{-b}, {b}}}, s.area_m2);
  }
  elements.finish();
  return elements;
}

TriangleElements triangle_elements(const SurfaceMesh& mesh) {
  const std::vector<double> areas = triangle_areas_m2(mesh);
  TriangleElements elements;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& n = mesh.triangles[t];
    Eigen::Matrix2d edges;
    edges.col(0) = mesh.way_m(n[0], n[1]);
    edges.col(1) = mesh.way_m(n[0], n[2]);
    elements.add(n, simplex_gradients<2>(edges), areas[t]);
  }
  elements.finish();
  return elements;
}

HingeElements hinge_elements(const std::vector<Hinge>& hinges) {
  HingeElements elements;
  for (const Hinge& h : hinges) elements.add(h.nodes, h.area_m2);
  elements.finish();
  return elements;
}

TetrahedronElements tetrahedron_elements(const SolidMesh& mesh) {
  TetrahedronElements elements;
  for (const auto& n : mesh.tetrahedra) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = mesh.rest_m.col(n[static_cast<std::size_t>(k) + 1]) - mesh.rest_m.col(n[0]);
    elements.add(n, simplex_gradients<3>(edges), edges.determinant() / 6.0);
  }
  elements.finish();
  return elements;
}

HexahedronPoints hexahedron_points(const SolidMesh& mesh) {
  const HexahedronCorners points = hexahedron_gauss_points();
  HexahedronPoints elements;
  for (const auto& n : mesh.hexahedra) {
    const HexahedronCorners rest = rest_corners(mesh, n);
    for (int p = 0; p < 8; ++p) {
      const Eigen::Matrix<double, 8, 3> slopes = hexahedron_slopes(points.col(p));
      const Eigen::Matrix3d jacobian = rest * slopes;
      const Eigen::Matrix<double, 8, 3> by_rest = slopes * jacobian.inverse();
      std::array<std::array<double, 3>, 8> gradients;
      for (int a = 0; a < 8; ++a)
        for (int i = 0; i < 3; ++i)
          gradients[static_cast<std::size_t>(a)][static_cast<std::size_t>(i)] = by_rest(a, i);
      elements.add(n, gradients, jacobian.determinant());
    }
  }
  elements.finish();
  return elements;
}

Eigen::Matrix3Xd hexahedron_point_places_m(const SolidMesh& mesh) {
  const HexahedronCorners points = hexahedron_gauss_points();
  Eigen::Matrix3Xd places(3, 8 * static_cast<Eigen::Index>(mesh.hexahedra.size()));
  Eigen::Index column = 0;
  for (const auto& n : mesh.hexahedra) {
    const HexahedronCorners rest = rest_corners(mesh, n);
    for (int p = 0; p < 8; ++p) places.col(column++) = rest * hexahedron_shape(points.col(p));
  }
  return places;
}

}  // namespace tenter::mechanics
