// SPDX-License-Identifier: Apache-2.0
// A surface as a shaded picture in SVG: seen from far away along a direction, lit from over the
// shoulder of who looks, triangles drawn from back to front.
//
//   shade = 0.35 + 0.65 |n . l|      n: the triangle's normal, l: to the light (Lambert)
//
// in 48 steps. Both sides are lit; the side that faces away from its normal has a warmer colour.
//
//   const View view{.eye = {0.3, -1, 0.4}};
//   const Extent extent = seen_extent(points, view);
//   std::string svg = painted_mesh(points, triangles, view, {.width = 300, .height = 200});
//
// Colours are part of the picture: it needs no style sheet. Triangles with a corner that is no node
// or not finite are left out. Sorting by the middle of the triangles: surfaces that pass through
// each other, and triangles much longer than their distance, may overlap wrongly. The same mesh
// gives the same bytes. Pure; any thread; cost of a sort of the triangles.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace tenter::report {

using Point3 = std::array<double, 3>;
using Corners = std::array<int, 3>;

struct View {
  Point3 eye = {0.3, -1.0, 0.4};  ///< direction to who looks
  Point3 up = {0.0, 0.0, 1.0};
};

/// What of the plane of the picture is taken up, to the right and up (m).
struct Extent {
  double lo_x = 0.0, hi_x = 0.0, lo_y = 0.0, hi_y = 0.0;
};

/// None without a finite point.
std::optional<Extent> seen_extent(const std::vector<Point3>& points, const View& view);

struct Canvas {
  double width = 300.0, height = 220.0, margin = 8.0;
  std::optional<double> pixels_per_m;  ///< none: as large as fits
};

/// Pixels per metre at which an extent just fits; none for a point.
std::optional<double> fitting_scale(const Extent& extent, const Canvas& canvas);

/// A group of paths, its middle in the middle of the canvas, whose upper left corner is (0, 0); ""
/// where there is nothing to see.
std::string painted_mesh(const std::vector<Point3>& points, const std::vector<Corners>& triangles,
                         const View& view, const Canvas& canvas);

}  // namespace tenter::report
