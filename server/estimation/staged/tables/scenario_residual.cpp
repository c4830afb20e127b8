// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/tables/scenario_residual.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/sequences/material_location.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::estimation {
namespace {

/// Nodes that the frame does not prescribe.
std::vector<bool> free_nodes(const mechanics::Boundary& boundary, int nodes) {
  std::vector<bool> is_free(static_cast<std::size_t>(nodes), true);
  for (const int n : boundary.held) is_free[static_cast<std::size_t>(n)] = false;
  for (const mechanics::Clip& clip : boundary.clips)
    if (!clip.is_free)
      for (const int n : clip.nodes) is_free[static_cast<std::size_t>(n)] = false;
  return is_free;
}

struct Sum {
  double squares = 0.0;
  int count = 0;
  void add(double square) {
    squares += square;
    ++count;
  }
  double root_mean() const { return count > 0 ? std::sqrt(squares / count) : 0.0; }
};

}  // namespace

Expected<ScenarioResidual> scenario_residual(const model::Model& model,
                                             const RoleSequence& measured, double tolerance_N) {
  const Sequence& whole = measured.sequence;
  // of shear, the forces along the clips
  const Sequence forces = observed(measured, Channels::thesis);
  const bool by_forces = rows_of(measured.role, Channels::thesis) != GapRows::positions;
  const Eigen::VectorXd parameters = mechanics::term_parameters(model);
  const auto found = resting_frames(model, whole, parameters, tolerance_N);
  if (!found) return tl::unexpected(found.error());

  std::vector<MaterialLocation> places;
  places.reserve(whole.points.size());
  for (const PointChannel& point : whole.points)
    places.push_back(*locate(whole.cloth.mesh, point.material_m));
  const Observations channels(forces);
  Observation observation;
  Sum force_sum, position_sum;
  for (std::size_t k = 0; k < found->resting.size(); ++k) {
    const auto f = static_cast<std::size_t>(found->resting[k]);
    const SequenceFrame& frame = whole.frames[f];
    const mechanics::Boundary& boundary =
        whole.boundaries[static_cast<std::size_t>(frame.boundary)];
    const std::vector<bool> is_free = free_nodes(boundary, whole.cloth.mesh.node_count());
    for (std::size_t p = 0; p < places.size(); ++p) {
      const Eigen::Vector3d seen = frame.points_m.col(static_cast<Eigen::Index>(p));
      bool moves = false;
      for (std::size_t a = 0; a < 3; ++a)
        moves |=
            places[p].weight[a] > 1e-6 && is_free[static_cast<std::size_t>(places[p].nodes[a])];
      if (moves && seen.allFinite())
        position_sum.add((places[p].position(found->states[k].x) - seen).squaredNorm());
    }
    for (int c = 0; by_forces && c < channels.count(); ++c) {
      const double value = channels.measured(forces.frames[f], c);
      if (channels.kind(forces, c) != ObservationKind::force || std::isnan(value)) continue;
      channels.observe(forces, c, {boundary, found->states[k], found->by_node_N[k]}, observation);
      force_sum.add((observation.value - value) * (observation.value - value));
    }
  }
  ScenarioResidual result;
  result.sequence = whole.name;
  result.role = measured.role;
  result.force_N = force_sum.root_mean();
  result.position_mm = 1e3 * position_sum.root_mean();
  result.force_rows = force_sum.count;
  result.points = position_sum.count;
  result.frames = static_cast<int>(found->resting.size());
  result.restless = static_cast<int>(found->restless.size());
  return result;
}

}  // namespace tenter::estimation
