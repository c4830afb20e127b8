// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {

namespace {

using std::to_string;

double doubled_area(const SurfaceMesh& mesh, const std::array<int, 3>& t) {
  const Eigen::Vector2d a = mesh.way_m(t[0], t[1]);
  const Eigen::Vector2d b = mesh.way_m(t[0], t[2]);
  return a.x() * b.y() - a.y() * b.x();
}

double longest_edge_squared(const SurfaceMesh& mesh, const std::array<int, 3>& t) {
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, mesh.way_m(t[k], t[(k + 1) % 3]).squaredNorm());
  return longest;
}

std::string named(std::size_t triangle, const std::array<int, 3>& t) {
  return "triangle " + to_string(triangle) + " (nodes " + to_string(t[0]) + ", " + to_string(t[1]) +
         ", " + to_string(t[2]) + ")";
}

Expected<void> check_sizes(const SurfaceMesh& mesh) {
  if (mesh.triangles.empty()) return bad_input("surface mesh: no triangles");
  const std::size_t count = mesh.triangles.size();
  if (!mesh.triangle_weight.empty() && mesh.triangle_weight.size() != count)
    return bad_input("surface mesh: " + to_string(mesh.triangle_weight.size()) + " weights for " +
                     to_string(count) + " triangles");
  if (!mesh.triangle_layer.empty() && mesh.triangle_layer.size() != count)
    return bad_input("surface mesh: " + to_string(mesh.triangle_layer.size()) + " layers for " +
                     to_string(count) + " triangles");
  for (std::size_t t = 0; t < mesh.triangle_weight.size(); ++t)
    if (!std::isfinite(mesh.triangle_weight[t]) || mesh.triangle_weight[t] <= 0.0)
      return bad_input("surface mesh: weight " + to_string(mesh.triangle_weight[t]) + " of " +
                       named(t, mesh.triangles[t]) + " is not positive");
  if (!(mesh.period_u_m >= 0.0) || !std::isfinite(mesh.period_u_m))
    return bad_input("surface mesh: a period of " + to_string(mesh.period_u_m) + " m");
  for (int node = 0; node < mesh.node_count(); ++node)
    if (!mesh.material_m.col(node).allFinite())
      return bad_input("surface mesh: node " + to_string(node) + " is not finite");
  return {};
}

Expected<void> check_triangle(const SurfaceMesh& mesh, std::size_t triangle) {
  const std::array<int, 3>& t = mesh.triangles[triangle];
  for (const int node : t)
    if (node < 0 || node >= mesh.node_count())
      return bad_input("surface mesh: " + named(triangle, t) + " names a node outside 0.." +
                       to_string(mesh.node_count() - 1));
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
    return bad_input("surface mesh: " + named(triangle, t) + " uses a node twice");
  if (mesh.period_u_m > 0.0)
    for (std::size_t k = 0; k < 3; ++k)
      if (!(3.0 * std::abs(mesh.way_m(t[k], t[(k + 1) % 3]).x()) < mesh.period_u_m))
        return bad_input("surface mesh: " + named(triangle, t) +
                         " goes a third of the way around the tube or more");
  const double area2 = doubled_area(mesh, t);
  const double longest2 = longest_edge_squared(mesh, t);
  // the negated comparison also refuses what overflowed
  if (!(std::abs(area2) > kFlattestTriangle * longest2) || !std::isfinite(longest2))
    return bad_input("surface mesh: " + named(triangle, t) + " is degenerate: twice its area is " +
                     to_string(area2) + " m2");
  if (area2 < 0.0)
    return bad_input("surface mesh: " + named(triangle, t) +
                     " is flipped: its corners run clockwise in the material plane");
  return {};
}

Expected<void> check_nodes_used(const SurfaceMesh& mesh) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.node_count()), false);
  for (const std::array<int, 3>& t : mesh.triangles)
    for (const int node : t) used[static_cast<std::size_t>(node)] = true;
  for (std::size_t node = 0; node < used.size(); ++node)
    if (!used[node])
      return bad_input("surface mesh: node " + to_string(node) + " belongs to no triangle");
  return {};
}

/// Counter-clockwise triangles pass an edge once each way; a second passage the same way is a third
/// triangle or a fold.
Expected<void> check_edges(const SurfaceMesh& mesh) {
  const std::vector<HalfEdge> sides = half_edges(mesh);
  for (std::size_t k = 1; k < sides.size(); ++k) {
    const HalfEdge& a = sides[k - 1];
    const HalfEdge& b = sides[k];
    if (a.layer == b.layer && a.low == b.low && a.high == b.high && a.rising == b.rising)
      return bad_input("surface mesh: the edge of nodes " + to_string(a.low) + " and " +
                       to_string(a.high) + " has triangles " + to_string(a.triangle) + " and " +
                       to_string(b.triangle) +
                       " on the same side: more than two triangles at an edge, or a fold");
  }
  return {};
}

std::vector<double> to_corners(const SurfaceMesh& mesh, double density) {
  std::vector<double> mass(static_cast<std::size_t>(mesh.node_count()), 0.0);
  const std::vector<double> area = triangle_areas_m2(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int node : mesh.triangles[t])
      mass[static_cast<std::size_t>(node)] += density * area[t] / 3.0;
  return mass;
}

}  // namespace

Expected<void> check(const SurfaceMesh& mesh) {
  if (Expected<void> sizes = check_sizes(mesh); !sizes) return sizes;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (Expected<void> triangle = check_triangle(mesh, t); !triangle) return triangle;
  if (Expected<void> edges = check_edges(mesh); !edges) return edges;
  return check_nodes_used(mesh);
}

Expected<SurfaceMesh> make_surface_mesh(Eigen::Matrix2Xd material_m,
                                        std::vector<std::array<int, 3>> triangles) {
  SurfaceMesh mesh;
  mesh.material_m = std::move(material_m);
  mesh.triangles = std::move(triangles);
  if (Expected<void> checked = check(mesh); !checked) return tl::unexpected(checked.error());
  return mesh;
}

std::vector<double> triangle_areas_m2(const SurfaceMesh& mesh) {
  std::vector<double> areas(mesh.triangles.size());
  for (std::size_t t = 0; t < areas.size(); ++t)
    areas[t] = 0.5 * doubled_area(mesh, mesh.triangles[t]) * mesh.weight(static_cast<int>(t));
  return areas;
}

std::vector<double> lumped_masses_kg(const SurfaceMesh& mesh, double area_density_kg_m2) {
  return to_corners(mesh, area_density_kg_m2);
}

std::vector<double> lumped_masses_of_total_kg(const SurfaceMesh& mesh, double total_mass_kg) {
  const std::vector<double> areas = triangle_areas_m2(mesh);
  return to_corners(mesh, total_mass_kg / std::accumulate(areas.begin(), areas.end(), 0.0));
}

}  // namespace tenter::mechanics
