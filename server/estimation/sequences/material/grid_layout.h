// SPDX-License-Identifier: GPL-3.0-or-later
// Where the lines of a simulated grid should lie for the clips and the table of one sequence.
//
// Lines run along the ends of clips, so that these clamp what they grip and no more. Beyond that:
//
//   corners of clips inside the specimen   stress has no bound there: lines grow dense towards them
//                                          (mesh/grid_lines.h)
//   a table's edges                        each half way between two lines (clamps_at_edge), what
//   is
//                                          always on the table one cell, so that those that hang
//                                          are the shorter
//   neither                                equal cells between the clips
//
// Measured in tests/bench/fabrics. Edges closer to each other than a cell cannot all have lines of
// their own: the first ones have. Where there are more ends than cells allow, those nearest to
// another line have none.
//
//   const auto lines = grid_layout({lo, hi, {{clip corners}}, {}}, {.nodes_u = 25, .nodes_v = 25});
//
// Pure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/mesh/grid.h"

namespace tenter::estimation {

struct SpecimenLayout {
  Eigen::Vector2d lo_m, hi_m;                         ///< the specimen's rectangle of material
  std::vector<std::vector<Eigen::Vector2d>> clips_m;  ///< corners of what each grips
  struct Edge {
    int axis = 0;  ///< 0: a place along u; 1: along v
    double at_m = 0.0;
    bool bears_above = false;  ///< the table lies beyond it
  };
  std::vector<Edge> edges;  ///< of tables, over all frames
};

struct LayoutOptions {
  int nodes_u = 25;
  int nodes_v = 25;
  double beta = 2.2;  ///< of the grading towards clips' corners; 1: none
};

/// bad_input as grid_mesh().
Expected<mechanics::GridLines> grid_layout(const SpecimenLayout& layout,
                                           const LayoutOptions& options);

}  // namespace tenter::estimation
