// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/cross_twin.h"

#include <limits>
#include <utility>

namespace tenter::twin {

Expected<CrossTwin> cross_twin(const Fabric& fabric, const Protocol& protocol,
                               CrossOptions options) {
  if (options.grid.points_m.empty())
    options.grid.points_m = irregular_places(fabric.side_m, options.places, options.sheet.seed);
  CrossTwin twin;
  twin.sequence = sequence_of(fabric, protocol, options.grid);
  estimation::Sequence& sequence = twin.sequence;

  // what is measured, then the nodes of the grid
  std::vector<Eigen::Vector2d> places;
  for (const estimation::PointChannel& point : sequence.points) places.push_back(point.material_m);
  const auto& mesh = sequence.cloth.mesh;
  for (int n = 0; n < mesh.node_count(); ++n) places.emplace_back(mesh.material_m.col(n));
  const SheetTwin sheet = run_protocol(fabric, protocol, places, options.sheet);
  if (!sheet.failure.empty()) return bad_input(sheet.failure);
  twin.unknowns = sheet.unknowns;
  twin.iterations = sheet.iterations;

  const auto seen = static_cast<Eigen::Index>(sequence.points.size());
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    estimation::SequenceFrame& frame = sequence.frames[f];
    frame.points_m = sheet.positions_m[f].leftCols(seen);
    if (const auto& table = protocol.frames[f].table)
      for (std::size_t k = 0; k < sequence.points.size(); ++k)
        if (table->contains(sequence.points[k].material_m))
          frame.points_m.col(static_cast<Eigen::Index>(k))
              .setConstant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
      const auto clip = static_cast<std::size_t>(sequence.forces[k].clip);
      frame.forces_N[static_cast<Eigen::Index>(k)] = sheet.clip_force_N[f][clip].dot(
          frame.clips[clip].rotation * sequence.forces[k].direction);
    }
    mechanics::State start;
    const Eigen::Matrix3Xd nodes = sheet.positions_m[f].rightCols(mesh.node_count());
    start.x = Eigen::Map<const Eigen::VectorXd>(nodes.data(), nodes.size());
    start.clips = frame.clips;
    frame.start = std::move(start);
  }
  return twin;
}

}  // namespace tenter::twin
