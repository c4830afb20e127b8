// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material/grid_layout.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/mesh/grid_lines.h"

namespace tenter::estimation {

namespace {

constexpr double kOnLine = 1e-6;  // of the specimen's extent

/// One axis in the making.
struct Axis {
  mechanics::LineGrading grading;
  std::vector<SpecimenLayout::Edge> edges;

  double cell_m() const { return (grading.hi_m - grading.lo_m) / grading.cells; }

  /// A line there, unless one is as near as `share` of a cell.
  void pass_through(double at, double share) {
    const double near_m = share * cell_m();
    const auto is_near = [&](double line) { return std::abs(line - at) < near_m; };
    if (at <= grading.lo_m || at >= grading.hi_m || is_near(grading.lo_m) ||
        is_near(grading.hi_m) ||
        std::any_of(grading.through_m.begin(), grading.through_m.end(), is_near))
      return;
    if (static_cast<int>(grading.through_m.size()) + 1 < grading.cells)
      grading.through_m.push_back(at);
  }

  /// Lines on either side of each edge, half a cell away, and one cell for what is always held.
  void clamp_at_edges() {
    std::sort(edges.begin(), edges.end(),
              [](const auto& a, const auto& b) { return a.at_m < b.at_m; });
    const bool above = edges.front().bears_above;
    const double low = edges.front().at_m, high = edges.back().at_m;
    const double free_m = above ? high - grading.lo_m : grading.hi_m - low;
    const double cell = free_m / (grading.cells - 1);
    double last = grading.lo_m - cell;
    for (const SpecimenLayout::Edge& edge : edges) {
      if (edge.at_m - last < cell * (1.0 - kOnLine)) continue;
      last = edge.at_m;
      pass_through(edge.at_m - 0.5 * cell, kOnLine);
      pass_through(edge.at_m + 0.5 * cell, kOnLine);
    }
    const double held = above ? high + cell : low - cell;
    if (held > grading.lo_m && held < grading.hi_m) grading.one_cell_at_m.push_back(held);
  }
};

}  // namespace

Expected<mechanics::GridLines> grid_layout(const SpecimenLayout& layout,
                                           const LayoutOptions& options) {
  Axis axes[2];
  const int cells[2] = {options.nodes_u - 1, options.nodes_v - 1};
  const double close_m = kOnLine * (layout.hi_m - layout.lo_m).maxCoeff();
  const auto is_inside = [&](double at, int axis) {
    return at > layout.lo_m[axis] + close_m && at < layout.hi_m[axis] - close_m;
  };
  for (int a = 0; a < 2; ++a) {
    axes[a].grading.lo_m = layout.lo_m[a];
    axes[a].grading.hi_m = layout.hi_m[a];
    axes[a].grading.cells = cells[a];
    axes[a].grading.beta = options.beta;
  }
  for (const SpecimenLayout::Edge& edge : layout.edges)
    if (is_inside(edge.at_m, edge.axis)) axes[edge.axis].edges.push_back(edge);
  for (const auto& clip : layout.clips_m)
    for (const Eigen::Vector2d& corner : clip) {
      const bool is_corner_inside = is_inside(corner.x(), 0) && is_inside(corner.y(), 1);
      for (int a = 0; a < 2; ++a) {
        constexpr double kNearest = 0.1;  // ends closer than so many cells share a line
        if (is_inside(corner[a], a)) axes[a].pass_through(corner[a], kNearest);
        auto& towards = axes[a].grading.towards_m;
        if (is_corner_inside && std::none_of(towards.begin(), towards.end(), [&](double at) {
              return std::abs(at - corner[a]) < close_m;
            }))
          towards.push_back(corner[a]);
      }
    }
  mechanics::GridLines lines;
  for (int a = 0; a < 2; ++a) {
    if (!axes[a].edges.empty()) axes[a].clamp_at_edges();
    auto made = mechanics::graded_lines(axes[a].grading);
    if (!made) return tl::unexpected(made.error());
    // what comes out equal is so to the last digit: points at nodes stay at nodes
    const double length = axes[a].grading.hi_m - axes[a].grading.lo_m;
    std::vector<double> equal;
    double off = 0.0;
    for (std::size_t k = 0; k < made->size(); ++k) {
      equal.push_back(axes[a].grading.lo_m + length * static_cast<double>(k) / cells[a]);
      off = std::max(off, std::abs(equal[k] - (*made)[k]));
    }
    (a == 0 ? lines.u_m : lines.v_m) = off < close_m ? std::move(equal) : std::move(*made);
  }
  if (auto good = check(lines); !good) return tl::unexpected(good.error());
  return lines;
}

}  // namespace tenter::estimation
