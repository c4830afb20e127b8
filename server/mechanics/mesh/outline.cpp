// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/outline.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "server/mechanics/mesh/smoothing.h"

namespace tenter::mechanics {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
using Polygon = CGAL::Polygon_2<Kernel>;
using VertexBase = CGAL::Triangulation_vertex_base_2<Kernel>;
using FaceBase = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Triangulation>;
using Mesher = CGAL::Delaunay_mesher_2<Triangulation, Criteria>;

/// Ratio of squared shortest edge and circumradius that refinement reaches: sin^2 of the smallest
/// angle, 20.7 degrees, the best bound for which it is known to end.
constexpr double kShape = 0.125;
/// Refinement bounds the longest edge of a triangle; the mean edge comes out at this part of it.
constexpr double kMeanOfLongest = 0.68;
constexpr int kSmoothings = 10;

/// The loop without its closing point, or what is wrong with it.
Expected<Polygon> checked_polygon(const std::vector<Eigen::Vector2d>& outline, double edge_length) {
  if (!std::isfinite(edge_length) || edge_length <= 0.0)
    return bad_input("outline: edge length " + std::to_string(edge_length) + " m is not positive");
  std::size_t count = outline.size();
  if (count > 1 && outline.front() == outline.back()) --count;
  if (count < 3)
    return bad_input("outline: " + std::to_string(count) + " corners; at least 3 are needed");
  if (count > static_cast<std::size_t>(kMostOutlineNodes))
    return bad_input("outline: " + std::to_string(count) + " corners are more than " +
                     std::to_string(kMostOutlineNodes));
  Polygon polygon;
  for (std::size_t k = 0; k < count; ++k) {
    if (!outline[k].allFinite())
      return bad_input("outline: corner " + std::to_string(k) + " is not finite");
    polygon.push_back(Point(outline[k].x(), outline[k].y()));
  }
  if (!polygon.is_simple()) return bad_input("outline: it crosses or touches itself");
  const double area = std::abs(polygon.area());
  const double smallest = 0.25 * std::sqrt(3.0) * edge_length * edge_length;
  if (!(area >= smallest))
    return bad_input("outline: its area of " + std::to_string(area * 1e6) +
                     " mm2 is too small for triangles of edge length " +
                     std::to_string(edge_length * 1e3) + " mm");
  if (polygon.is_clockwise_oriented()) polygon.reverse_orientation();
  return polygon;
}

/// About how many nodes will be made: inside by area (an equilateral triangulation has
/// 2 / (sqrt(3) l^2) nodes per area), on the sides by length, and where the piece is narrower than
/// the edge length by length over mean width.
double expected_nodes(const Polygon& polygon, double edge_length) {
  double sides = 0.0;
  double length = 0.0;
  for (auto side = polygon.edges_begin(); side != polygon.edges_end(); ++side) {
    length += std::sqrt(side->squared_length());
    sides += std::ceil(std::sqrt(side->squared_length()) / edge_length);
  }
  const double area = std::abs(polygon.area());
  return sides + 2.0 / std::sqrt(3.0) * area / (edge_length * edge_length) +
         0.5 * length * length / area;
}

/// The outline as constraints, sides cut into equal pieces.
void insert_outline(const Polygon& polygon, double edge_length, Triangulation& triangulation) {
  const std::size_t count = polygon.size();
  std::vector<Triangulation::Vertex_handle> loop;
  for (std::size_t k = 0; k < count; ++k) {
    const Point& a = polygon[k];
    const Point& b = polygon[(k + 1) % count];
    const double length = std::sqrt(CGAL::squared_distance(a, b));
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / edge_length - 1e-9)));
    for (int piece = 0; piece < pieces; ++piece) {
      const double t = static_cast<double>(piece) / pieces;
      loop.push_back(
          triangulation.insert(Point(a.x() + t * (b.x() - a.x()), a.y() + t * (b.y() - a.y()))));
    }
  }
  for (std::size_t k = 0; k < loop.size(); ++k)
    triangulation.insert_constraint(loop[k], loop[(k + 1) % loop.size()]);
}

/// Fills the inside. False if it takes more than `most` nodes.
bool refine(double edge_length, std::size_t most, Triangulation& triangulation) {
  Mesher mesher(triangulation, Criteria(kShape, edge_length / kMeanOfLongest));
  mesher.init();
  while (!mesher.is_refinement_done()) {
    if (triangulation.number_of_vertices() > most) return false;
    if (!mesher.try_one_step_refine_mesh()) break;
  }
  return true;
}

/// Nodes in the order of (u, v), triangles from their smallest node, in the order of nodes: nothing
/// of the order in which they were made, or of addresses, is left.
Expected<SurfaceMesh> numbered(const Triangulation& triangulation) {
  std::vector<std::array<Point, 3>> corners;
  std::map<std::pair<double, double>, int> index;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end();
       ++face) {
    if (!face->is_in_domain()) continue;
    corners.push_back(
        {face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point()});
    for (const Point& p : corners.back()) index[{p.x(), p.y()}] = 0;
  }
  Eigen::Matrix2Xd material(2, static_cast<Eigen::Index>(index.size()));
  int next = 0;
  for (auto& [place, number] : index) {
    material.col(next) << place.first, place.second;
    number = next++;
  }
  std::vector<std::array<int, 3>> triangles;
  triangles.reserve(corners.size());
  for (const std::array<Point, 3>& face : corners) {
    std::array<int, 3> t{};
    for (std::size_t k = 0; k < 3; ++k) t[k] = index.at({face[k].x(), face[k].y()});
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return make_surface_mesh(std::move(material), std::move(triangles));
}

}  // namespace

Expected<SurfaceMesh> triangulate_outline(const std::vector<Eigen::Vector2d>& outline_m,
                                          double edge_length_m) {
  const Expected<Polygon> polygon = checked_polygon(outline_m, edge_length_m);
  if (!polygon) return tl::unexpected(polygon.error());
  const double expected = expected_nodes(*polygon, edge_length_m);
  const Error too_many{ErrorKind::bad_input,
                       "outline: edges of " + std::to_string(edge_length_m * 1e3) +
                           " mm make more than " + std::to_string(kMostOutlineNodes) + " nodes"};
  if (!(expected < kMostOutlineNodes)) return tl::unexpected(too_many);

  Triangulation triangulation;
  insert_outline(*polygon, edge_length_m, triangulation);
  if (!refine(edge_length_m, kMostOutlineNodes, triangulation)) return tl::unexpected(too_many);
  Expected<SurfaceMesh> mesh = numbered(triangulation);
  if (mesh) smooth(*mesh, kSmoothings);
  return mesh;
}

}  // namespace tenter::mechanics
