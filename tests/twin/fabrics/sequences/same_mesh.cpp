// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/same_mesh.h"

#include <cmath>
#include <limits>

#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::twin {

namespace {

using estimation::Sequence;
using mechanics::EquilibriumSolver;
using mechanics::State;

/// Where a place of the material is; none where it lies on held nodes only, which are not seen: in
/// the triangle with the least negative barycentric weight.
Eigen::Vector3d position_at(const mechanics::SurfaceMesh& mesh, const Eigen::Vector2d& place,
                            const Eigen::VectorXd& x, const std::vector<bool>& is_held) {
  const auto twice = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  constexpr double kSmall = 1e-9;
  double best = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d found = Eigen::Vector3d::Zero();
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector2d a = mesh.material_m.col(t[0]), b = mesh.material_m.col(t[1]),
                          c = mesh.material_m.col(t[2]);
    const double whole = twice(b - a, c - a);
    const Eigen::Vector3d w(twice(b - place, c - place) / whole,
                            twice(c - place, a - place) / whole,
                            twice(a - place, b - place) / whole);
    if (w.minCoeff() <= best) continue;
    best = w.minCoeff();
    found.setZero();
    bool is_seen = false;
    for (std::size_t k = 0; k < 3; ++k) {
      found += w[static_cast<Eigen::Index>(k)] * x.segment<3>(3 * t[k]);
      is_seen = is_seen || (std::abs(w[static_cast<Eigen::Index>(k)]) > kSmall &&
                            !is_held[static_cast<std::size_t>(t[k])]);
    }
    if (!is_seen) found.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return found;
}

void record(const State& state, const Eigen::VectorXd& by_node, std::size_t f, Sequence& sequence) {
  estimation::SequenceFrame& frame = sequence.frames[f];
  const mechanics::Boundary& boundary =
      sequence.boundaries[static_cast<std::size_t>(frame.boundary)];
  std::vector<bool> is_held(static_cast<std::size_t>(sequence.cloth.mesh.node_count()), false);
  for (const int node : boundary.held) is_held[static_cast<std::size_t>(node)] = true;
  for (std::size_t k = 0; k < sequence.points.size(); ++k)
    frame.points_m.col(static_cast<Eigen::Index>(k)) =
        position_at(sequence.cloth.mesh, sequence.points[k].material_m, state.x, is_held);
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const auto& clip = boundary.clips[static_cast<std::size_t>(sequence.forces[k].clip)];
    // the cords bear what the cloth pulls and what the clip weighs
    Eigen::Vector3d borne = -clip.mass_kg * sequence.loads.gravity_m_s2;
    for (const int node : clip.nodes)
      borne += by_node.segment<3>(3 * static_cast<Eigen::Index>(node));
    const auto& turn = frame.clips[static_cast<std::size_t>(sequence.forces[k].clip)].rotation;
    frame.forces_N[static_cast<Eigen::Index>(k)] = borne.dot(turn * sequence.forces[k].direction);
  }
}

}  // namespace

Expected<MeasuredTwin> measure_model(const model::Model& description, Sequence sequence) {
  auto model = mechanics::MeshModel::make(description, sequence.cloth);
  if (!model) return tl::unexpected(model.error());
  const Eigen::VectorXd parameters = mechanics::term_parameters(description);
  MeasuredTwin twin;
  State state = sequence.start;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const estimation::SequenceFrame& frame = sequence.frames[f];
    auto solver = EquilibriumSolver::make(
        *model, sequence.boundaries[static_cast<std::size_t>(frame.boundary)]);
    if (!solver) return tl::unexpected(solver.error());
    mechanics::Loads loads = sequence.loads;
    loads.cord_force_N = frame.cord_force_N;
    prescribe(sequence, f, true, state);
    mechanics::EquilibriumOptions options;
    options.minimiser = mechanics::Minimiser::additive_lm;
    options.tolerance_N = 1e-9;
    options.max_iterations = 400;
    State trial = state;
    auto solved = solver->solve(parameters, loads, trial, options);
    if (solved && !solved->is_good(options)) {
      options.minimiser = mechanics::Minimiser::newton;
      options.max_iterations = 4000;
      trial = state;
      solved = solver->solve(parameters, loads, trial, options);
      ++twin.finished_by_newton;
    }
    if (!solved) return tl::unexpected(solved.error());
    if (!solved->is_good(options))
      return bad_input("sequence \"" + sequence.name + "\", frame " + std::to_string(f + 1) + ": " +
                       describe(*solved, options));
    state = trial;
    record(state, solved->by_node, f, sequence);
    sequence.frames[f].start = state;
    twin.states.push_back(state);
    twin.by_node_N.push_back(std::move(solved->by_node));
  }
  twin.sequence = std::move(sequence);
  return twin;
}

Expected<MeasuredTwin> same_mesh_twin(const Fabric& fabric, const Protocol& protocol,
                                      const GridOptions& options) {
  return measure_model(fabric_model(fabric), sequence_of(fabric, protocol, options));
}

}  // namespace tenter::twin
