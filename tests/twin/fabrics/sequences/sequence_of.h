// SPDX-License-Identifier: GPL-3.0-or-later
// A protocol on a grid, as the estimator takes it, with nothing measured yet: mesh, masses, clips
// and the table's edge, channels, poses of every frame.
//
// Clips are prescribed (their poses are seen). What lies on the table is held, with one boundary
// for each place of the edge. Channels: the points asked for that no clip covers, and of each clip
// the cords' force along its pull; but for stretch then also the force across it, which of the
// picture frame is the one parallel to the clip (thesis 3.4.1). Directions turn with the clips.
//
//   Sequence s = sequence_of(fabric, make_protocol(fabric, "shear"), {.nodes = 25});
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/sequences/sequence.h"
#include "tests/twin/fabrics/protocols.h"

namespace tenter::twin {

struct GridOptions {
  int nodes = 25;  ///< a side; nodes - 1 is a multiple of the protocol's cells unless graded
  /// Lines as estimation::grid_layout puts them, with this beta; 0: equal cells. Graded grids hold
  /// the line beyond the table's edge.
  double grading = 0.0;
  mechanics::Diagonals diagonals = mechanics::Diagonals::both;  ///< see fabric_model.h
  /// Material places that are seen; none: all nodes.
  std::vector<Eigen::Vector2d> points_m = {};
  double point_sigma_m = 7.5e-5;  ///< thesis 3.2.3
  double force_sigma_N = 3e-3;    ///< of each cord's sensor
  /// What the table holds. False: the nodes on it (thesis 3.4.1). True: one line of nodes more,
  /// half a cell beyond the edge, so that the sheet is clamped at the edge itself: the hinges at
  /// the last held line bend and stand for half a cell on either side of it. Without, a strip hangs
  /// as if it were a cell longer.
  bool holds_line_beyond_edge = false;
};

/// Load cells that the force of a clip is the sum of: two cords on a long clip, one on a corner's.
int cord_count(const ProtocolClip& clip);

/// Values that are measured later are NaN. Aborts where the grid does not fit the protocol.
estimation::Sequence sequence_of(const Fabric& fabric, const Protocol& protocol,
                                 const GridOptions& options = {});

}  // namespace tenter::twin
