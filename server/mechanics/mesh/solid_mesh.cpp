// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/solid_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "server/mechanics/mesh/hexahedron.h"

namespace tenter::mechanics {

namespace {

using std::to_string;

double six_volumes(const SolidMesh& mesh, const std::array<int, 4>& t) {
  const Eigen::Vector3d a = mesh.rest_m.col(t[1]) - mesh.rest_m.col(t[0]);
  const Eigen::Vector3d b = mesh.rest_m.col(t[2]) - mesh.rest_m.col(t[0]);
  const Eigen::Vector3d c = mesh.rest_m.col(t[3]) - mesh.rest_m.col(t[0]);
  return a.cross(b).dot(c);
}

HexahedronCorners corners_of(const SolidMesh& mesh, const std::array<int, 8>& h) {
  HexahedronCorners corners;
  for (int a = 0; a < 8; ++a) corners.col(a) = mesh.rest_m.col(h[static_cast<std::size_t>(a)]);
  return corners;
}

/// A hexahedron's Jacobian where it is smallest, times 8: of a brick, the product of its edges.
double least_jacobian(const HexahedronCorners& corners) {
  double least = 8.0 * hexahedron_jacobian(corners, Eigen::Vector3d::Zero());
  for (const HexahedronCorners& places : {hexahedron_corners(), hexahedron_gauss_points()})
    for (int q = 0; q < 8; ++q)
      least = std::min(least, 8.0 * hexahedron_jacobian(corners, places.col(q)));
  return least;
}

template <std::size_t N>
std::string named(const char* kind, std::size_t element, const std::array<int, N>& nodes) {
  std::string text = std::string(kind) + " " + to_string(element) + " (nodes";
  for (const int node : nodes) text += " " + to_string(node);
  return text + ")";
}

template <std::size_t N>
Expected<void> check_nodes(const SolidMesh& mesh, const char* kind, std::size_t element,
                           const std::array<int, N>& nodes) {
  for (const int node : nodes)
    if (node < 0 || node >= mesh.node_count())
      return bad_input("solid mesh: " + named(kind, element, nodes) + " names a node outside 0.." +
                       to_string(mesh.node_count() - 1));
  std::array<int, N> sorted = nodes;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    return bad_input("solid mesh: " + named(kind, element, nodes) + " uses a node twice");
  return {};
}

/// `jacobian`: as kFlattestSolid has it.
template <std::size_t N>
Expected<void> check_volume(const SolidMesh& mesh, const char* kind, std::size_t element,
                            const std::array<int, N>& nodes, double jacobian) {
  double longest = 0.0;
  for (const int a : nodes)
    for (const int b : nodes)
      longest = std::max(longest, (mesh.rest_m.col(a) - mesh.rest_m.col(b)).norm());
  const double scale = longest * longest * longest;
  // the negated comparison also refuses what overflowed
  if (!std::isfinite(scale) || !(std::abs(jacobian) > kFlattestSolid * scale))
    return bad_input("solid mesh: " + named(kind, element, nodes) +
                     " is degenerate: its smallest Jacobian is " + to_string(jacobian) + " m3");
  if (jacobian < 0.0)
    return bad_input("solid mesh: " + named(kind, element, nodes) +
                     " is left-handed or folded: its Jacobian is negative");
  return {};
}

Expected<void> check_elements(const SolidMesh& mesh) {
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const std::array<int, 4>& t = mesh.tetrahedra[e];
    Expected<void> checked = check_nodes(mesh, "tetrahedron", e, t);
    if (checked) checked = check_volume(mesh, "tetrahedron", e, t, six_volumes(mesh, t));
    if (!checked) return checked;
  }
  for (std::size_t e = 0; e < mesh.hexahedra.size(); ++e) {
    const std::array<int, 8>& h = mesh.hexahedra[e];
    Expected<void> checked = check_nodes(mesh, "hexahedron", e, h);
    if (checked)
      checked = check_volume(mesh, "hexahedron", e, h, least_jacobian(corners_of(mesh, h)));
    if (!checked) return checked;
  }
  return {};
}

constexpr int kTetrahedronFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
constexpr int kHexahedronFaces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Sorted nodes of a face; a triangle's first is -1.
using Face = std::array<int, 4>;

Expected<void> check_faces(const SolidMesh& mesh) {
  std::vector<Face> faces;
  for (const std::array<int, 4>& t : mesh.tetrahedra)
    for (const auto& f : kTetrahedronFaces)
      faces.push_back({-1, t[static_cast<std::size_t>(f[0])], t[static_cast<std::size_t>(f[1])],
                       t[static_cast<std::size_t>(f[2])]});
  for (const std::array<int, 8>& h : mesh.hexahedra)
    for (const auto& f : kHexahedronFaces)
      faces.push_back({h[static_cast<std::size_t>(f[0])], h[static_cast<std::size_t>(f[1])],
                       h[static_cast<std::size_t>(f[2])], h[static_cast<std::size_t>(f[3])]});
  for (Face& face : faces) std::sort(face.begin(), face.end());
  std::sort(faces.begin(), faces.end());
  for (std::size_t k = 2; k < faces.size(); ++k)
    if (faces[k] == faces[k - 2])
      return bad_input("solid mesh: more than two elements at the face of nodes " +
                       to_string(faces[k][1]) + ", " + to_string(faces[k][2]) + ", " +
                       to_string(faces[k][3]));
  return {};
}

Expected<void> check_nodes_used(const SolidMesh& mesh) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.node_count()), false);
  for (const auto& t : mesh.tetrahedra)
    for (const int node : t) used[static_cast<std::size_t>(node)] = true;
  for (const auto& h : mesh.hexahedra)
    for (const int node : h) used[static_cast<std::size_t>(node)] = true;
  for (std::size_t node = 0; node < used.size(); ++node)
    if (!used[node])
      return bad_input("solid mesh: node " + to_string(node) + " belongs to no element");
  return {};
}

}  // namespace

Expected<void> check(const SolidMesh& mesh) {
  if (mesh.tetrahedra.empty() && mesh.hexahedra.empty())
    return bad_input("solid mesh: no elements");
  for (int node = 0; node < mesh.node_count(); ++node)
    if (!mesh.rest_m.col(node).allFinite())
      return bad_input("solid mesh: node " + to_string(node) + " is not finite");
  if (Expected<void> elements = check_elements(mesh); !elements) return elements;
  if (Expected<void> faces = check_faces(mesh); !faces) return faces;
  return check_nodes_used(mesh);
}

std::vector<double> volumes_m3(const SolidMesh& mesh) {
  std::vector<double> volumes;
  volumes.reserve(mesh.tetrahedra.size() + mesh.hexahedra.size());
  for (const auto& t : mesh.tetrahedra) volumes.push_back(six_volumes(mesh, t) / 6.0);
  const HexahedronCorners points = hexahedron_gauss_points();
  for (const auto& h : mesh.hexahedra) {
    const HexahedronCorners corners = corners_of(mesh, h);
    double volume = 0.0;
    for (int q = 0; q < 8; ++q) volume += hexahedron_jacobian(corners, points.col(q));
    volumes.push_back(volume);
  }
  return volumes;
}

std::vector<double> lumped_masses_kg(const SolidMesh& mesh, double density_kg_m3) {
  std::vector<double> mass(static_cast<std::size_t>(mesh.node_count()), 0.0);
  for (const auto& t : mesh.tetrahedra)
    for (const int node : t)
      mass[static_cast<std::size_t>(node)] += density_kg_m3 * six_volumes(mesh, t) / 24.0;
  const HexahedronCorners points = hexahedron_gauss_points();
  for (const auto& h : mesh.hexahedra) {
    const HexahedronCorners corners = corners_of(mesh, h);
    for (int q = 0; q < 8; ++q) {
      const double part = density_kg_m3 * hexahedron_jacobian(corners, points.col(q));
      const Eigen::Matrix<double, 8, 1> shape = hexahedron_shape(points.col(q));
      for (int a = 0; a < 8; ++a)
        mass[static_cast<std::size_t>(h[static_cast<std::size_t>(a)])] += part * shape[a];
    }
  }
  return mass;
}

std::vector<double> lumped_masses_of_total_kg(const SolidMesh& mesh, double total_mass_kg) {
  const std::vector<double> volumes = volumes_m3(mesh);
  return lumped_masses_kg(mesh,
                          total_mass_kg / std::accumulate(volumes.begin(), volumes.end(), 0.0));
}

}  // namespace tenter::mechanics
