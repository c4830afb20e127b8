// SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of observation: its value against a closed form, its derivative against differences of
// whole solves.
#include "server/estimation/sequences/observations.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/estimation/sequences/bars.h"

namespace tenter::estimation {
namespace {

using mechanics::rotation_of;
using testing::between_bars;
using testing::cloth_model;
using testing::true_values;

/// All kinds on a sheet that is stretched, sheared and twisted; the scalars have measured zero.
Sequence with_every_kind() {
  Sequence sequence = between_bars("all", false, {0.005, 0.004, 0.002});
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    sequence.frames[f].clips[1].rotation =
        rotation_of(0.02 * (static_cast<double>(f) + 1.0) * Eigen::Vector3d(0.5, 0.3, -1.0));
  sequence.forces.push_back({1, Eigen::Vector3d::UnitX(), 2e-3, true});
  sequence.forces.push_back({0, Eigen::Vector3d::UnitY(), 2e-3, true});
  for (mechanics::Clip& clip : sequence.boundaries[0].clips) {
    clip.mass_kg = 0.003;
    clip.centre_of_mass_m = {0.05, 0.05, 0.01};
  }
  sequence.scalars = {
      TorqueChannel{{{0, 1.0}, {1, -1.0}}, {0.05, 0.05, 0.0}, Eigen::Vector3d(0, 0.6, 0.8), 1e-4},
      LengthChannel{{0.031, 0.03}, {0.069, 0.071}, 1e-5}, AreaChannel{1e-6}};
  for (SequenceFrame& frame : sequence.frames) {
    frame.forces_N.setZero(3);
    frame.scalars.setZero(3);
  }
  return sequence;
}

void compare_with_differences(const Sequence& sequence, bool forces_matter) {
  const Eigen::VectorXd at = true_values();
  SequenceOptions options;
  options.threads = 2;
  options.tolerance_N = 1e-12;
  auto evaluator = SequenceEvaluator::make(cloth_model(at), {sequence}, options).value();
  Eigen::VectorXd residuals, high, low;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator.evaluate(at, residuals, &jacobian), mechanics::PathStatus::ok)
      << evaluator.failure();
  const RowMatrix taken = jacobian;
  std::vector<double> size(static_cast<std::size_t>(evaluator.rows().back().channel) + 1, 0.0);
  for (int p = 0; p < evaluator.parameter_count(); ++p) {
    const double h = 1e-4 * at[p];
    Eigen::VectorXd up = at, down = at;
    up[p] += h;
    down[p] -= h;
    ASSERT_EQ(evaluator.evaluate(up, high, nullptr), mechanics::PathStatus::ok);
    ASSERT_EQ(evaluator.evaluate(down, low, nullptr), mechanics::PathStatus::ok);
    std::vector<double> off(size.size(), 0.0), whole(size.size(), 0.0);
    for (int r = 0; r < evaluator.row_count(); ++r) {
      const auto c =
          static_cast<std::size_t>(evaluator.rows()[static_cast<std::size_t>(r)].channel);
      const double difference = (high[r] - low[r]) / (2.0 * h);
      off[c] += std::pow(taken(r, p) - difference, 2);
      whole[c] += difference * difference;
    }
    for (std::size_t c = 0; c < size.size(); ++c) {
      // differences are good to the rounding of residuals, sixteen digits of their size
      EXPECT_LT(std::sqrt(off[c]), 1e-5 * std::sqrt(whole[c]) + 1e-6 / at[p])
          << "channel " << c << ", parameter " << p;
      size[c] += std::sqrt(whole[c]) * at[p];
    }
  }
  const std::size_t first_force = 3 * sequence.points.size();
  for (std::size_t c = 0; c < size.size(); ++c)
    if (forces_matter || c < first_force || c >= first_force + sequence.forces.size()) {
      EXPECT_GT(size[c], 1e-2) << c;  // every channel says something
    }
}

TEST(Observations, FollowWholeSolvesWithPrescribedClips) {
  compare_with_differences(with_every_kind(), true);
}

TEST(Observations, FollowWholeSolvesWithAFreeClipInSomeFrames) {
  Sequence sequence = with_every_kind();
  sequence.forces.resize(1);
  sequence.scalars.erase(sequence.scalars.begin());  // torques are of prescribed clips
  sequence.boundaries.push_back(sequence.boundaries[0]);
  mechanics::Clip& free = sequence.boundaries[1].clips[1];
  free.is_free = true;
  free.cord_place_m = {{0.01, 0.11, 0.0}, {0.09, 0.11, 0.0}};
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    SequenceFrame& frame = sequence.frames[f];
    frame.forces_N.setZero(1);
    frame.scalars.setZero(2);
    if (f < 2) continue;
    frame.boundary = 1;
    frame.cord_force_N = {{}, {{-0.05, 0.15, 0.02}, {0.1, 0.1, 0.03}}};
  }
  compare_with_differences(sequence, false);
}

/// The adjoint's gradient of the cost beside the Jacobian's, with weights that differ.
TEST(Observations, TheAdjointGivesTheGradientOfTheCost) {
  std::vector<Sequence> sequences = {with_every_kind(),
                                     between_bars("other", true, {0.006, 0.001, 0.0})};
  sequences[1].weight = 3.0;
  const Eigen::VectorXd at = true_values();
  auto evaluator = SequenceEvaluator::make(cloth_model(at), sequences, {.threads = 2}).value();
  double cost = 0.0;
  Eigen::VectorXd gradient, residuals;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator.evaluate_gradient(at, cost, gradient), mechanics::PathStatus::ok)
      << evaluator.failure();
  ASSERT_EQ(evaluator.evaluate(at, residuals, &jacobian), mechanics::PathStatus::ok);
  const Eigen::VectorXd weighted = evaluator.weights().cwiseProduct(residuals);
  EXPECT_NEAR(cost, weighted.dot(residuals), 1e-9 * cost);
  EXPECT_GT(gradient.cwiseProduct(at).cwiseAbs().minCoeff(), 1e-6 * cost);
  for (int p = 0; p < evaluator.parameter_count(); ++p)
    EXPECT_NEAR(gradient[p], 2.0 * jacobian.col(p).dot(weighted), 1e-6 * std::abs(gradient[p]))
        << p;
}

TEST(Observations, AreWhatTheyAreCalled) {
  Sequence sequence = with_every_kind();
  ASSERT_TRUE(check(sequence)) << check(sequence).error().message;
  const Observations channels(sequence);
  const int first_force = 3 * 9;
  ASSERT_EQ(channels.count(), first_force + 3 + 3);
  // the sheet drawn to twice its width and turned, and a gradient on the nodes of the second clip
  mechanics::State state;
  const Eigen::Matrix3d turn = rotation_of({0.2, -0.5, 0.9});
  const int nodes = sequence.cloth.mesh.node_count();
  state.x.resize(3 * nodes);
  for (int n = 0; n < nodes; ++n)
    state.x.segment<3>(3 * n) = turn * Eigen::Vector3d(2.0 * sequence.cloth.mesh.material_m(0, n),
                                                       sequence.cloth.mesh.material_m(1, n), 0.0);
  state.clips = {{}, {turn, Eigen::Vector3d::Zero()}};
  Eigen::VectorXd by_node = Eigen::VectorXd::Zero(3 * nodes);
  const mechanics::Clip& clip = sequence.boundaries[0].clips[1];
  const Eigen::Vector3d force(0.3, -0.2, 0.5);
  by_node.segment<3>(3 * static_cast<Eigen::Index>(clip.nodes[2])) = force;
  const RestState at{sequence.boundaries[0], state, by_node};
  const Eigen::Vector3d weight = clip.mass_kg * sequence.loads.gravity_m_s2;
  Observation seen;
  channels.observe(sequence, first_force + 1, at, seen);
  EXPECT_NEAR(seen.value, (turn * Eigen::Vector3d::UnitX()).dot(force - weight), 1e-15);
  channels.observe(sequence, first_force + 3, at, seen);
  const auto& torque = std::get<TorqueChannel>(sequence.scalars[0]);
  const Eigen::Vector3d place = state.x.segment<3>(3 * static_cast<Eigen::Index>(clip.nodes[2]));
  const Eigen::Vector3d first_centre = clip.centre_of_mass_m - torque.about_m;
  const Eigen::Vector3d centre = turn * clip.centre_of_mass_m - torque.about_m;
  const Eigen::Vector3d sum =
      -first_centre.cross(weight) -
      (Eigen::Vector3d(place - torque.about_m).cross(force) - centre.cross(weight));
  EXPECT_NEAR(seen.value, torque.axis.dot(sum), 1e-15);
  channels.observe(sequence, first_force + 4, at, seen);
  EXPECT_NEAR(seen.value, std::hypot(2.0 * 0.038, 0.041), 1e-12);
  channels.observe(sequence, first_force + 5, at, seen);
  EXPECT_NEAR(seen.value, 2.0 * 0.1 * 0.1, 1e-12);
}

TEST(Observations, SayWhatTheyCannotBe) {
  const auto message = [](const Sequence& sequence) {
    const auto ok = check(sequence);
    return ok ? std::string() : ok.error().message;
  };
  Sequence sequence = with_every_kind();
  std::get<TorqueChannel>(sequence.scalars[0]).axis *= 2.0;
  EXPECT_EQ(message(sequence), "sequence \"all\": scalar 1 has an axis that is not of length one");
  sequence = with_every_kind();
  sequence.boundaries[0].clips[1].is_free = true;
  EXPECT_EQ(message(sequence),
            "sequence \"all\": force 2 is of a free clip, on which only its known cords act");
  sequence = with_every_kind();
  std::get<LengthChannel>(sequence.scalars[1]).to_m.x() = 0.3;
  EXPECT_EQ(message(sequence), "sequence \"all\": scalar 2 ends outside of the mesh");
  sequence = with_every_kind();
  sequence.frames[1].boundary = 1;
  EXPECT_EQ(message(sequence), "sequence \"all\": frame 2 is of boundary 1, which there is not");
}

/// A strip over a table's edge: other nodes are held in every frame, where the frame says.
TEST(Observations, AStripIsPushedOverAnEdge) {
  Sequence sequence = between_bars("pushed", false, {0.0, 0.001, 0.0});
  const mechanics::State flat = sequence.start;
  sequence.forces.clear();
  sequence.boundaries.clear();
  sequence.start.clips.clear();
  for (std::size_t f = 0; f < 3; ++f) {
    mechanics::Boundary boundary;
    for (int j = 0; j < 6 - static_cast<int>(f); ++j)
      for (int i = 0; i < 9; ++i) boundary.held.push_back(9 * j + i);
    SequenceFrame& frame = sequence.frames[f];
    frame.boundary = static_cast<int>(f);
    frame.clips.clear();
    frame.forces_N.resize(0);
    frame.held_m.resize(3, static_cast<Eigen::Index>(boundary.held.size()));
    for (std::size_t k = 0; k < boundary.held.size(); ++k)
      frame.held_m.col(static_cast<Eigen::Index>(k)) =
          flat.x.segment<3>(3 * static_cast<Eigen::Index>(boundary.held[k])) +
          Eigen::Vector3d(0.0, 0.0125 * static_cast<double>(f), 0.0);
    if (f == 2) frame.start = flat;
    sequence.boundaries.push_back(boundary);
  }
  sequence.frames.resize(3);
  auto evaluator = SequenceEvaluator::make(cloth_model(true_values()), {sequence}, {}).value();
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator.evaluate(true_values(), residuals, &jacobian), mechanics::PathStatus::ok)
      << evaluator.failure();
  double drop = 0.0;
  for (std::size_t f = 0; f < 3; ++f) {
    const mechanics::State& state = evaluator.states()[0][f];
    const auto& held = sequence.boundaries[f].held;
    EXPECT_EQ(Eigen::Vector3d(state.x.segment<3>(3 * static_cast<Eigen::Index>(held.back()))),
              Eigen::Vector3d(sequence.frames[f].held_m.rightCols<1>()));
    const double lower = state.x[3 * 76 + 2];  // the middle of the free end
    EXPECT_LT(lower, drop - 1e-3);             // hangs lower the farther it is pushed
    drop = lower;
  }
  // on the way of a fit, too, threads change nothing
  auto other = SequenceEvaluator::make(cloth_model(true_values()), {sequence}, {2}).value();
  evaluator = SequenceEvaluator::make(cloth_model(true_values()), {sequence}, {}).value();
  Eigen::VectorXd other_residuals;
  RowMatrix other_jacobian;
  for (auto* each : {&evaluator, &other}) each->set_accuracy(Accuracy::stepping);
  for (const double scale : {1.0, 1.2, 0.9}) {
    const Eigen::VectorXd at = scale * true_values();
    ASSERT_EQ(evaluator.evaluate(at, residuals, &jacobian), mechanics::PathStatus::ok);
    ASSERT_EQ(other.evaluate(at, other_residuals, &other_jacobian), mechanics::PathStatus::ok);
    EXPECT_EQ(residuals, other_residuals);
    EXPECT_EQ(jacobian, other_jacobian);
  }
}

}  // namespace
}  // namespace tenter::estimation
