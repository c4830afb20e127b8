// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/sequence_of.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "server/estimation/sequences/material/grid_layout.h"

namespace tenter::twin {

namespace {

using estimation::Sequence;
using estimation::SequenceFrame;

/// Flat, and hanging through a little: the way that gravity goes.
mechanics::State flat_start(const mechanics::SurfaceMesh& mesh, double side_m) {
  constexpr double kSag = 5e-3;  // of the side
  mechanics::State state;
  state.x.resize(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double u = mesh.material_m(0, n), v = mesh.material_m(1, n);
    const double bump = std::sin(M_PI * u / side_m) * std::sin(M_PI * v / side_m);
    state.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << u, v, -kSag * side_m * bump;
  }
  return state;
}

std::vector<int> nodes_in(const mechanics::SurfaceMesh& mesh, const Region& region) {
  std::vector<int> nodes;
  for (int n = 0; n < mesh.node_count(); ++n)
    if (region.contains(mesh.material_m.col(n))) nodes.push_back(n);
  return nodes;
}

/// Up to the table's edge, or to the first line beyond it.
std::vector<int> nodes_on_table(const mechanics::SurfaceMesh& mesh,
                                const mechanics::GridLines& lines, Region table,
                                bool holds_line_beyond_edge) {
  const auto next = [](const std::vector<double>& of, double edge) {
    constexpr double kSlack_m = 1e-9;
    const auto line = std::lower_bound(of.begin(), of.end(), edge - kSlack_m);
    return line == of.end() ? edge : std::max(*line, edge);
  };
  if (holds_line_beyond_edge) {
    table.hi_u = next(lines.u_m, table.hi_u);
    table.hi_v = next(lines.v_m, table.hi_v);
  }
  return nodes_in(mesh, table);
}

/// As the estimator would lay them for a capture of the protocol.
mechanics::GridLines graded_lines(const Protocol& protocol, const GridOptions& options) {
  estimation::SpecimenLayout layout;
  layout.lo_m.setZero();
  layout.hi_m.setConstant(protocol.side_m);
  for (const ProtocolClip& clip : protocol.clips) {
    const Region& r = clip.grip;
    layout.clips_m.push_back(
        {{r.lo_u, r.lo_v}, {r.hi_u, r.lo_v}, {r.hi_u, r.hi_v}, {r.lo_u, r.hi_v}});
  }
  for (const ProtocolFrame& frame : protocol.frames) {
    if (!frame.table) continue;
    const bool along_u = frame.table->hi_u < protocol.side_m;
    layout.edges.push_back({along_u ? 0 : 1, along_u ? frame.table->hi_u : frame.table->hi_v});
  }
  return estimation::grid_layout(layout, {options.nodes, options.nodes, options.grading}).value();
}

mechanics::Clip clip_of(const std::string& id, const mechanics::SurfaceMesh& mesh,
                        const Region& region, double mass_kg) {
  mechanics::Clip clip;
  clip.id = id;
  clip.nodes = nodes_in(mesh, region);
  for (const int n : clip.nodes)
    clip.place_m.emplace_back(mesh.material_m(0, n), mesh.material_m(1, n), 0.0);
  clip.mass_kg = mass_kg;
  clip.centre_of_mass_m << 0.5 * (region.lo_u + region.hi_u), 0.5 * (region.lo_v + region.hi_v),
      0.0;
  return clip;
}

/// Boundaries of all frames, equal ones once, and which is whose.
void add_boundaries(const Protocol& protocol, const mechanics::GridLines& lines,
                    bool holds_line_beyond_edge, Sequence& sequence) {
  std::vector<double> edges;  // lo and hi of u and v tell tables apart
  for (const ProtocolFrame& frame : protocol.frames) {
    const double edge = frame.table ? frame.table->hi_u + 2.0 * frame.table->hi_v : 0.0;
    const auto found = std::find(edges.begin(), edges.end(), edge);
    sequence.frames.emplace_back().boundary = static_cast<int>(found - edges.begin());
    if (found != edges.end()) continue;
    edges.push_back(edge);
    mechanics::Boundary boundary;
    for (const ProtocolClip& clip : protocol.clips)
      boundary.clips.push_back(clip_of(clip.id, sequence.cloth.mesh, clip.grip, clip.mass_kg));
    if (frame.table)
      boundary.held =
          nodes_on_table(sequence.cloth.mesh, lines, *frame.table, holds_line_beyond_edge);
    sequence.boundaries.push_back(std::move(boundary));
  }
}

bool is_covered(const Protocol& protocol, const Eigen::Vector2d& material_m) {
  return std::any_of(protocol.clips.begin(), protocol.clips.end(),
                     [&](const ProtocolClip& clip) { return clip.grip.contains(material_m); });
}

void add_channels(const Protocol& protocol, const GridOptions& options, Sequence& sequence) {
  std::vector<Eigen::Vector2d> places = options.points_m;
  if (places.empty())
    for (int n = 0; n < sequence.cloth.mesh.node_count(); ++n)
      places.emplace_back(sequence.cloth.mesh.material_m.col(n));
  for (const Eigen::Vector2d& place : places)
    if (!is_covered(protocol, place)) sequence.points.push_back({place, options.point_sigma_m});
  const bool is_stretch = protocol.name.starts_with("stretch");
  for (std::size_t c = 0; c < protocol.clips.size(); ++c) {
    const ProtocolClip& clip = protocol.clips[c];
    estimation::ForceChannel force;
    force.clip = static_cast<int>(c);
    force.sigma_N = options.force_sigma_N * std::sqrt(cord_count(clip));
    force.turns_with_clip = true;
    force.direction = clip.pull;
    sequence.forces.push_back(force);
    if (is_stretch) continue;
    force.direction = Eigen::Vector3d::UnitZ().cross(clip.pull);
    sequence.forces.push_back(force);
  }
}

}  // namespace

int cord_count(const ProtocolClip& clip) {
  constexpr double kSmallest_m2 = 4e-4;  // a corner's clip grips no more
  const Region& grip = clip.grip;
  return (grip.hi_u - grip.lo_u) * (grip.hi_v - grip.lo_v) < kSmallest_m2 &&
                 std::abs((grip.hi_u - grip.lo_u) - (grip.hi_v - grip.lo_v)) < 1e-9
             ? 1
             : 2;
}

Sequence sequence_of(const Fabric& fabric, const Protocol& protocol, const GridOptions& options) {
  const bool is_graded = options.grading > 0.0;
  if (options.nodes < 2 || (!is_graded && (options.nodes - 1) % protocol.cells != 0)) std::abort();
  Sequence sequence;
  sequence.name = protocol.name;
  const mechanics::Grid grid{options.nodes, options.nodes, fabric.side_m, fabric.side_m};
  const mechanics::GridLines lines =
      is_graded ? graded_lines(protocol, options) : mechanics::lines_of(grid);
  sequence.cloth = mechanics::cloth_of_grid(lines, options.diagonals).value();
  sequence.start = flat_start(sequence.cloth.mesh, fabric.side_m);
  const auto masses = mechanics::lumped_masses_of_total_kg(sequence.cloth.mesh, fabric.mass_kg);
  sequence.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  add_boundaries(protocol, lines, options.holds_line_beyond_edge || is_graded, sequence);
  add_channels(protocol, options, sequence);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t f = 0; f < protocol.frames.size(); ++f) {
    const ProtocolFrame& from = protocol.frames[f];
    SequenceFrame& frame = sequence.frames[f];
    for (const ClipPose& pose : from.poses) frame.clips.push_back({pose.rotation, pose.position_m});
    const auto& held = sequence.boundaries[static_cast<std::size_t>(frame.boundary)].held;
    frame.held_m.setZero(3, static_cast<Eigen::Index>(held.size()));
    for (std::size_t i = 0; i < held.size(); ++i)
      frame.held_m.col(static_cast<Eigen::Index>(i)).head<2>() =
          sequence.cloth.mesh.material_m.col(held[i]);
    frame.block = from.block;
    frame.points_m.setConstant(3, static_cast<Eigen::Index>(sequence.points.size()), kNone);
    frame.forces_N.setConstant(static_cast<Eigen::Index>(sequence.forces.size()), kNone);
  }
  sequence.start.clips = sequence.frames.front().clips;
  prescribe(sequence, 0, true, sequence.start);
  mechanics::place_clips(sequence.boundaries.front(), sequence.start);
  return sequence;
}

}  // namespace tenter::twin
