// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/estimation/sequences/bars.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/presets.h"
#include "server/estimation/prediction.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation::testing {

using mechanics::EquilibriumOptions;
using mechanics::EquilibriumSolver;
using mechanics::Grid;
using mechanics::MeshModel;
using mechanics::Pose;

constexpr double kSize_m = 0.1;
constexpr double kPointSigma_m = 2e-5;
constexpr double kForceSigma_N = 2e-3;

model::Model cloth_model(const Eigen::VectorXd& values) {
  model::Model model = model::preset("cloth_stvk").value();
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i]->value = values[static_cast<Eigen::Index>(i)];
  return model;
}

Eigen::VectorXd true_values() {
  Eigen::VectorXd values(6);
  values << 45.0, 80.0, 9.0, 2e-4, 2e-4, 2e-4;
  return values;
}

Sequence between_bars(const std::string& name, bool along_weft, const Eigen::Vector3d& moved) {
  Sequence sequence;
  sequence.name = name;
  const Grid grid{9, 9, kSize_m, kSize_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating).value();
  const auto& mesh = sequence.cloth.mesh;
  sequence.start.x.resize(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n)
    sequence.start.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << mesh.material_m(0, n),
        mesh.material_m(1, n),
        1e-4 * std::sin(100.0 * mesh.material_m(0, n) + 70.0 * mesh.material_m(1, n));
  std::vector<int> first, second;
  for (int i = 0; i < 9; ++i) {
    first.push_back(along_weft ? grid.node(0, i) : grid.node(i, 0));
    second.push_back(along_weft ? grid.node(8, i) : grid.node(i, 8));
  }
  const Pose at_rest;
  sequence.boundaries.resize(1);
  sequence.boundaries[0].clips = {clip_on("fixed", first, sequence.start.x, at_rest),
                                  clip_on("moved", second, sequence.start.x, at_rest)};
  sequence.start.clips = {at_rest, at_rest};
  const auto masses = mechanics::lumped_masses_kg(mesh, 0.15);
  sequence.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  for (const double u : {0.031, 0.052, 0.07})
    for (const double v : {0.028, 0.049, 0.073}) sequence.points.push_back({{u, v}, kPointSigma_m});
  sequence.forces = {{1, moved.normalized(), kForceSigma_N}};
  constexpr int kFrames = 5;
  for (int f = 0; f < kFrames; ++f) {
    SequenceFrame frame;
    Pose pose;
    pose.position_m = moved * (f + 1.0) / kFrames;
    frame.clips = {at_rest, pose};
    frame.points_m.setZero(3, static_cast<Eigen::Index>(sequence.points.size()));
    frame.forces_N.setZero(1);
    frame.block = 0;
    sequence.frames.push_back(frame);
  }
  return sequence;
}

void measure(Sequence& sequence, const Eigen::VectorXd& truth, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const MeshModel model = MeshModel::make(cloth_model(truth), sequence.cloth).value();
  auto solver = EquilibriumSolver::make(model, sequence.boundaries[0]).value();
  EquilibriumOptions options;
  options.minimiser = mechanics::Minimiser::additive_lm;
  options.tolerance_N = 1e-9;
  mechanics::State state = sequence.start;
  for (SequenceFrame& frame : sequence.frames) {
    state.clips = frame.clips;
    const auto result = solver.solve(truth, sequence.loads, state, options);
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_TRUE(result->is_good(options)) << describe(*result, options);
    for (Eigen::Index k = 0; k < frame.points_m.cols(); ++k) {
      // bilinear over the cell would do as well: nodes are dense, and the fit has its own way
      const Eigen::Vector2d at = sequence.points[static_cast<std::size_t>(k)].material_m;
      Eigen::Vector3d position = Eigen::Vector3d::Zero();
      for (const auto& t : sequence.cloth.mesh.triangles) {
        const auto corner = [&](int c) -> Eigen::Vector2d {
          return sequence.cloth.mesh.material_m.col(t[static_cast<std::size_t>(c)]);
        };
        const auto twice = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
          return a.x() * b.y() - a.y() * b.x();
        };
        const double whole = twice(corner(1) - corner(0), corner(2) - corner(0));
        const double w0 = twice(corner(1) - at, corner(2) - at) / whole;
        const double w1 = twice(corner(2) - at, corner(0) - at) / whole;
        const double w2 = 1.0 - w0 - w1;
        if (std::min({w0, w1, w2}) < -1e-12) continue;
        position = w0 * state.x.segment<3>(3 * t[0]) + w1 * state.x.segment<3>(3 * t[1]) +
                   w2 * state.x.segment<3>(3 * t[2]);
      }
      for (int c = 0; c < 3; ++c)
        frame.points_m(c, k) = position[c] + kPointSigma_m * normal(random);
    }
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (const int node : sequence.boundaries[0].clips[1].nodes)
      pull += result->by_node.segment<3>(3 * node);
    frame.forces_N[0] = pull.dot(sequence.forces[0].direction) + kForceSigma_N * normal(random);
  }
}

std::vector<Sequence> measured_sequences(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Sequence> sequences = {between_bars("weft", true, {0.006, 0.0, 0.0}),
                                     between_bars("warp", false, {0.0, 0.006, 0.0}),
                                     between_bars("shear", false, {0.008, 0.001, 0.0})};
  for (Sequence& sequence : sequences) measure(sequence, true_values(), random);
  return sequences;
}

}  // namespace tenter::estimation::testing
