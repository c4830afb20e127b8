// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/cross_twin.h"

#include <limits>
#include <utility>

namespace tenter::twin {

namespace {

using estimation::Sequence;

/// What the rig sees of the sheet in a frame; nothing of what lies on the table.
void measure(const SheetTwin& sheet, const Protocol& protocol, std::size_t f, Sequence& sequence) {
  estimation::SequenceFrame& frame = sequence.frames[f];
  frame.points_m = sheet.positions_m[f].leftCols(static_cast<Eigen::Index>(sequence.points.size()));
  if (const auto& table = protocol.frames[f].table)
    for (std::size_t k = 0; k < sequence.points.size(); ++k)
      if (table->contains(sequence.points[k].material_m))
        frame.points_m.col(static_cast<Eigen::Index>(k))
            .setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const auto clip = static_cast<std::size_t>(sequence.forces[k].clip);
    frame.forces_N[static_cast<Eigen::Index>(k)] =
        sheet.clip_force_N[f][clip].dot(frame.clips[clip].rotation * sequence.forces[k].direction);
  }
}

}  // namespace

Expected<std::vector<CrossTwin>> cross_twins(const Fabric& fabric, const Protocol& protocol,
                                             CrossOptions options, const std::vector<int>& nodes) {
  if (options.grid.points_m.empty())
    options.grid.points_m = irregular_places(fabric.side_m, options.places, options.sheet.seed);
  std::vector<CrossTwin> twins;
  for (const int count : nodes) {
    options.grid.nodes = count;
    twins.emplace_back().sequence = sequence_of(fabric, protocol, options.grid);
  }
  if (twins.empty()) return twins;

  // what is measured, then the nodes of each grid
  std::vector<Eigen::Vector2d> places;
  for (const estimation::PointChannel& point : twins.front().sequence.points)
    places.push_back(point.material_m);
  std::vector<Eigen::Index> first;
  for (const CrossTwin& twin : twins) {
    first.push_back(static_cast<Eigen::Index>(places.size()));
    const auto& mesh = twin.sequence.cloth.mesh;
    for (int n = 0; n < mesh.node_count(); ++n) places.emplace_back(mesh.material_m.col(n));
  }
  const SheetTwin sheet = run_protocol(fabric, protocol, places, options.sheet);
  if (!sheet.failure.empty()) return bad_input(sheet.failure);

  for (std::size_t t = 0; t < twins.size(); ++t) {
    CrossTwin& twin = twins[t];
    twin.unknowns = sheet.unknowns;
    twin.iterations = sheet.iterations;
    for (std::size_t f = 0; f < twin.sequence.frames.size(); ++f) {
      measure(sheet, protocol, f, twin.sequence);
      mechanics::State start;
      const Eigen::Matrix3Xd at = sheet.positions_m[f].middleCols(
          first[t], static_cast<Eigen::Index>(twin.sequence.cloth.mesh.node_count()));
      start.x = Eigen::Map<const Eigen::VectorXd>(at.data(), at.size());
      start.clips = twin.sequence.frames[f].clips;
      twin.sequence.frames[f].start = std::move(start);
    }
  }
  return twins;
}

Expected<CrossTwin> cross_twin(const Fabric& fabric, const Protocol& protocol,
                               CrossOptions options) {
  const int nodes = options.grid.nodes;
  auto twins = cross_twins(fabric, protocol, std::move(options), {nodes});
  if (!twins) return tl::unexpected(twins.error());
  return std::move(twins->front());
}

}  // namespace tenter::twin
