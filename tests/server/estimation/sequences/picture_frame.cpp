// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/estimation/sequences/picture_frame.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "server/estimation/prediction.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::estimation::testing {

using mechanics::Grid;
using mechanics::Pose;

namespace {

constexpr double kSide_m = 0.1;

struct FramePose {
  double open = 0.0;   ///< of the side
  double angle = 0.0;  ///< of shear, rad
};

// never twice at the same place from the same side, and never back to the start
constexpr FramePose kPath[] = {{0.005, 0.0},  {0.012, 0.0},   {0.018, 0.03}, {0.02, 0.07},
                               {0.02, 0.11},  {0.018, 0.08},  {0.02, 0.05},  {0.02, 0.09},
                               {0.022, 0.14}, {0.02, 0.10},   {0.014, 0.05}, {0.02, 0.01},
                               {0.02, -0.04}, {0.018, -0.01}, {0.018, 0.06}};

/// Bars below, above, left and right; each keeps its length and turns about its middle.
std::vector<Pose> poses_at(const FramePose& at) {
  const double side = kSide_m * (1.0 + at.open);
  const Eigen::Vector3d along(1.0, 0.0, 0.0), up(std::sin(at.angle), std::cos(at.angle), 0.0);
  const Eigen::Vector3d centre(0.5 * kSide_m, 0.5 * kSide_m, 0.0);
  const Eigen::Matrix3d turn = mechanics::rotation_of({0.0, 0.0, -at.angle});
  const auto pose = [&](const Eigen::Matrix3d& rotation, const Eigen::Vector3d& middle,
                        const Eigen::Vector3d& rest) {
    return Pose{rotation, middle - rotation * rest};
  };
  const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
  return {pose(none, centre - 0.5 * side * up, {0.5 * kSide_m, 0.0, 0.0}),
          pose(none, centre + 0.5 * side * up, {0.5 * kSide_m, kSide_m, 0.0}),
          pose(turn, centre - 0.5 * side * along, {0.0, 0.5 * kSide_m, 0.0}),
          pose(turn, centre + 0.5 * side * along, {kSide_m, 0.5 * kSide_m, 0.0})};
}

}  // namespace

model::Model rubbing_cloth(const Eigen::VectorXd& values) {
  model::Model model = model::preset("cloth_stvk").value();
  model::Term friction;
  friction.id = "shear_friction";
  friction.strain.name = "green_uv";
  friction.law.name = "dahl";
  friction.law.parameters = model::default_parameters(*model::find_law("dahl"), 1);
  model.terms.push_back(friction);
  const auto parameters = parameters_of(model);
  for (std::size_t p = 0; p < parameters.size(); ++p)
    parameters[p]->value = values[static_cast<Eigen::Index>(p)];
  // a flat sheet says nothing of bending
  for (const std::size_t known : {3U, 4U, 5U, 8U}) parameters[known]->fixed = true;
  return model;
}

Eigen::VectorXd rubbing_values() {
  Eigen::VectorXd values(10);
  values << 45.0, 80.0, 9.0, 2e-4, 2e-4, 2e-4, 0.25, 1.5, 0.0, 0.015;
  return values;
}

Sequence picture_frame(int nodes) {
  Sequence sequence;
  sequence.name = "picture frame";
  const Grid grid{nodes, nodes, kSide_m, kSide_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::alternating).value();
  const auto& mesh = sequence.cloth.mesh;
  sequence.start.x.setZero(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    sequence.start.x.segment<2>(3 * static_cast<Eigen::Index>(n)) = mesh.material_m.col(n);
    sequence.points.push_back({mesh.material_m.col(n), 2e-5});
  }
  std::vector<int> sides[4];
  for (int i = nodes / 4; i < nodes - nodes / 4; ++i) {
    sides[0].push_back(grid.node(i, 0));
    sides[1].push_back(grid.node(i, nodes - 1));
    sides[2].push_back(grid.node(0, i));
    sides[3].push_back(grid.node(nodes - 1, i));
  }
  sequence.boundaries.resize(1);
  const char* names[] = {"below", "above", "left", "right"};
  for (std::size_t c = 0; c < 4; ++c)
    sequence.boundaries[0].clips.push_back(clip_on(names[c], sides[c], sequence.start.x, Pose{}));
  sequence.start.clips.resize(4);
  sequence.forces = {{1, Eigen::Vector3d::UnitX(), 1e-3},
                     {1, Eigen::Vector3d::UnitY(), 1e-3},
                     {3, Eigen::Vector3d::UnitX(), 1e-3}};
  for (const FramePose& at : kPath) {
    SequenceFrame frame;
    frame.clips = poses_at(at);
    frame.points_m.setZero(3, mesh.node_count());
    frame.forces_N.setZero(3);
    sequence.frames.push_back(frame);
  }
  return sequence;
}

void measure(Sequence& sequence, const model::Model& model, const Eigen::VectorXd& truth,
             double noise, unsigned seed) {
  for (SequenceFrame& frame : sequence.frames) {
    frame.points_m.setZero();
    frame.forces_N.setZero();
  }
  auto exact = SequenceEvaluator::make(model, {sequence}).value();
  Eigen::VectorXd seen;
  if (exact.evaluate(truth, seen, nullptr) != mechanics::PathStatus::ok)
    throw std::runtime_error(exact.failure());
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto points = 3 * static_cast<int>(sequence.points.size());
  for (int r = 0; r < exact.row_count(); ++r) {
    const Row& row = exact.rows()[static_cast<std::size_t>(r)];
    SequenceFrame& frame = sequence.frames[static_cast<std::size_t>(row.frame)];
    const double value = seen[r] + noise * normal(random);
    if (row.channel < points)
      frame.points_m(row.channel % 3, row.channel / 3) = value * sequence.points[0].sigma_m;
    else
      frame.forces_N[row.channel - points] = value * sequence.forces[0].sigma_N;
  }
}

}  // namespace tenter::estimation::testing
