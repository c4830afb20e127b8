// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet cut into triangles: the constant half of everything that acts on cloth.
//
// Nodes live in the material plane, u = weft and v = warp (thesis 3.3.1), in metres; triangles run
// counter-clockwise there. Where the sheet is in space is the state's business, not the mesh's.
//
// Layers. A sheet may be covered more than once, each covering (layer) being a triangulation of its
// own with a share of the material: `Diagonals::both` of grid.h is two layers of weight 1/2 over
// the same nodes. Whatever is integrated over the sheet is the sum over layers of weight times the
// layer's integral; edges and hinges are found within a layer. One plain triangulation leaves both
// lists empty: one layer, weight 1.
//
// Tubes. Where a sheet closes on itself, u and u + period_u_m are one place: way_m() is the short
// way between two nodes, and every length, area and gradient is made of such ways (tube.h).
//
//   auto mesh = make_surface_mesh(material_m, triangles);
//   if (!mesh) return tl::unexpected(mesh.error());
//   const std::vector<double> mass = lumped_masses_kg(*mesh, 0.187);
//
// Pure functions, callable from any thread; all costs are linear up to a sort of the edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/error.h"

namespace tenter::mechanics {

struct SurfaceMesh {
  Eigen::Matrix2Xd material_m;                ///< (u, v) of each node
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise in the material plane
  std::vector<double> triangle_weight;        ///< share of the material; empty = all 1
  std::vector<int> triangle_layer;            ///< covering it belongs to; empty = all 0
  double period_u_m = 0.0;                    ///< of a tube; 0: an open sheet

  int node_count() const { return static_cast<int>(material_m.cols()); }
  int triangle_count() const { return static_cast<int>(triangles.size()); }
  /// In the material from one node to another that is less than half a period away.
  Eigen::Vector2d way_m(int from, int to) const {
    Eigen::Vector2d way = material_m.col(to) - material_m.col(from);
    if (period_u_m > 0.0) way.x() -= period_u_m * std::round(way.x() / period_u_m);
    return way;
  }
  double weight(int triangle) const {
    return triangle_weight.empty() ? 1.0 : triangle_weight[static_cast<std::size_t>(triangle)];
  }
  int layer(int triangle) const {
    return triangle_layer.empty() ? 0 : triangle_layer[static_cast<std::size_t>(triangle)];
  }
};

/// A triangle's smallest height over its longest edge must exceed this: below it, strains are made
/// of rounding.
inline constexpr double kFlattestTriangle = 1e-6;

/// What every function below and every term takes for granted: finite nodes, indices in range,
/// three different corners, positive area (not flipped, not near-degenerate), at most two triangles
/// at an edge of one layer, no node without a triangle, weights positive and finite, edges that go
/// less than a third of the way around a tube. bad_input names the triangle, edge or node. Two
/// triangles of one layer that overlap without sharing an edge are not looked for: pieces of a
/// garment may lie over each other in the plane.
Expected<void> check(const SurfaceMesh& mesh);

/// The mesh, or what is wrong with it.
Expected<SurfaceMesh> make_surface_mesh(Eigen::Matrix2Xd material_m,
                                        std::vector<std::array<int, 3>> triangles);

/// Area of each triangle times its weight: they sum to the area of the sheet.
std::vector<double> triangle_areas_m2(const SurfaceMesh& mesh);

/// Mass of each node: a third of each triangle to each corner.
std::vector<double> lumped_masses_kg(const SurfaceMesh& mesh, double area_density_kg_m2);

/// The same shape of distribution, scaled to the weighed mass of the specimen.
std::vector<double> lumped_masses_of_total_kg(const SurfaceMesh& mesh, double total_mass_kg);

}  // namespace tenter::mechanics
