// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/estimation/staged/small_rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/presets.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation {
namespace {

using mechanics::Pose;

constexpr double kSide_m = 0.1;

Sequence sheet(const std::string& name, const RigOptions& options) {
  Sequence sequence;
  sequence.name = name;
  const mechanics::Grid grid{options.nodes, options.nodes, kSide_m, kSide_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating).value();
  const auto& mesh = sequence.cloth.mesh;
  sequence.start.x.resize(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    sequence.start.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << mesh.material_m(0, n),
        mesh.material_m(1, n), 0.0;
    sequence.points.push_back({mesh.material_m.col(n), options.point_sigma_m});
  }
  const auto masses = mechanics::lumped_masses_kg(mesh, 0.15);
  sequence.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  return sequence;
}

void add_frame(Sequence& sequence, std::vector<Pose> poses, int boundary) {
  SequenceFrame frame;
  frame.boundary = boundary;
  frame.clips = std::move(poses);
  frame.points_m.setZero(3, static_cast<Eigen::Index>(sequence.points.size()));
  frame.forces_N.setZero(static_cast<Eigen::Index>(sequence.forces.size()));
  sequence.frames.push_back(frame);
}

/// Two bars; the second goes by `moved`.
Sequence between_bars(const std::string& name, bool along_weft, const Eigen::Vector3d& moved,
                      const RigOptions& options) {
  Sequence sequence = sheet(name, options);
  const mechanics::Grid grid{options.nodes, options.nodes, kSide_m, kSide_m};
  const int last = options.nodes - 1;
  std::vector<int> first, second;
  for (int i = 0; i < options.nodes; ++i) {
    first.push_back(along_weft ? grid.node(0, i) : grid.node(i, 0));
    second.push_back(along_weft ? grid.node(last, i) : grid.node(i, last));
  }
  const Pose rest;
  mechanics::Boundary boundary;
  boundary.clips = {clip_on("fixed", first, sequence.start.x, rest),
                    clip_on("moved", second, sequence.start.x, rest)};
  sequence.boundaries = {boundary};
  sequence.start.clips = {rest, rest};
  const Eigen::Vector3d across = along_weft ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d along = along_weft ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  sequence.forces = {{1, across, options.force_sigma_N}, {1, along, options.force_sigma_N}};
  for (int f = 1; f <= options.frames; ++f) {
    Pose pose;
    pose.position_m = moved * f / options.frames;
    add_frame(sequence, {rest, pose}, 0);
  }
  return sequence;
}

/// Pushed over the edge of a table: what lies on it is held.
Sequence over_edge(const std::string& name, bool along_weft, const RigOptions& options) {
  Sequence sequence = sheet(name, options);
  const auto& material = sequence.cloth.mesh.material_m;
  const double cell = kSide_m / (options.nodes - 1);
  const int most = std::min(options.frames, options.nodes - 3);
  for (int f = 0; f < most; ++f) {
    mechanics::Boundary boundary;
    const double edge = kSide_m - cell * (options.nodes - 2 - most + f + 0.5);
    for (int n = 0; n < sequence.cloth.mesh.node_count(); ++n)
      if (material(along_weft ? 0 : 1, n) < edge) boundary.held.push_back(n);
    sequence.boundaries.push_back(boundary);
    add_frame(sequence, {}, f);
  }
  return sequence;
}

void measure(Sequence& sequence, const model::Model& truth, const RigOptions& options,
             unsigned stream) {
  std::mt19937 random(1000 * options.seed + stream);
  std::normal_distribution<double> normal;
  const auto model = mechanics::MeshModel::make(truth, sequence.cloth).value();
  const Eigen::VectorXd parameters = mechanics::term_parameters(truth);
  mechanics::EquilibriumOptions solving;
  solving.tolerance_N = 0.0;
  mechanics::State state = sequence.start;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    SequenceFrame& frame = sequence.frames[f];
    const auto& boundary = sequence.boundaries[static_cast<std::size_t>(frame.boundary)];
    auto solver = mechanics::EquilibriumSolver::make(model, boundary).value();
    prescribe(sequence, f, true, state);
    const auto result = solver.solve(parameters, sequence.loads, state, solving);
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_TRUE(result->is_good(solving)) << sequence.name << describe(*result, solving);
    for (Eigen::Index k = 0; k < frame.points_m.cols(); ++k)
      for (int c = 0; c < 3; ++c)
        frame.points_m(c, k) =
            state.x[3 * k + c] + options.noise * options.point_sigma_m * normal(random);
    for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
      const ForceChannel& force = sequence.forces[k];
      const auto pull = mechanics::reaction(boundary.clips[static_cast<std::size_t>(force.clip)],
                                            state.x, result->by_node, Eigen::Vector3d::Zero());
      frame.forces_N[static_cast<Eigen::Index>(k)] =
          -force.direction.dot(pull.force_N) +
          options.noise * options.force_sigma_N * normal(random);
    }
  }
}

}  // namespace

RoleSequence measured_in_rig(Role role, const model::Model& truth, const RigOptions& options) {
  Sequence sequence;
  switch (role) {
    case Role::stretch_u:
      sequence = between_bars("stretch_u", true, {0.006, 0.0, 0.0}, options);
      break;
    case Role::stretch_v:
      sequence = between_bars("stretch_v", false, {0.0, 0.006, 0.0}, options);
      break;
    case Role::shear:
      sequence = between_bars("shear", false, {0.02, 0.002, 0.0}, options);
      break;
    case Role::bend_u:
      sequence = over_edge("bend_u", true, options);
      break;
    case Role::bend_v:
      sequence = over_edge("bend_v", false, options);
      break;
    case Role::evaluation:
      sequence = between_bars("diagonal pull", true, {0.004, 0.008, 0.0}, options);
      break;
  }
  measure(sequence, truth, options, static_cast<unsigned>(role));
  return {role, std::move(sequence)};
}

std::vector<RoleSequence> measured_in_rig(const model::Model& truth, const RigOptions& options) {
  std::vector<RoleSequence> all;
  for (const Role role :
       {Role::stretch_u, Role::stretch_v, Role::shear, Role::bend_u, Role::bend_v})
    all.push_back(measured_in_rig(role, truth, options));
  return all;
}

model::Model curved_cloth() {
  model::Model model = model::preset("cloth_stvk_spline").value();
  const std::vector<std::vector<double>> curves = {{40.0, 40.0, 60.0, 120.0, 160.0},
                                                   {90.0, 80.0, 60.0, 60.0, 60.0},
                                                   {14.0, 10.0, 8.0, 10.0, 14.0},
                                                   {2e-5},
                                                   {6e-5},
                                                   {3e-5}};
  for (std::size_t t = 0; t < curves.size(); ++t) {
    model::Law& law = model.terms[t].law;
    law.parameters.resize(curves[t].size());
    for (std::size_t k = 0; k < curves[t].size(); ++k) law.parameters[k].value = curves[t][k];
    law.range_lo = t == 2 ? -0.2 : 0.0;
    law.range_hi = t == 2 ? 0.2 : 0.07;
  }
  return model;
}

}  // namespace tenter::estimation
