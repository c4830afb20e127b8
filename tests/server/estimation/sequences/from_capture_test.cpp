// SPDX-License-Identifier: GPL-3.0-or-later
// Captured sheets as sequences: what was simulated, written into a capture and made into a sequence
// has no residual at the parameters it was simulated with; nothing is left out silently.
#include "server/estimation/sequences/from_capture.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "common/base/not_a_number.h"
#include "common/model/presets.h"
#include "server/estimation/fit.h"
#include "server/estimation/sequences/material/material_locator.h"
#include "server/estimation/sequences/material/measured_state.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation {
namespace {

using capture::Capture;
using capture::Sheet;
using mechanics::EquilibriumSolver;

constexpr int kSide = 9;
constexpr double kSize_m = 0.1;
constexpr mechanics::Diagonals kDiagonals = mechanics::Diagonals::alternating;

/// Options that simulate as the data were made.
FromCaptureOptions same_grid() {
  FromCaptureOptions options;
  options.nodes_u = options.nodes_v = kSide;
  options.diagonals = kDiagonals;
  return options;
}

model::Model cloth_model() {
  model::Model model = model::preset("cloth_stvk").value();
  const std::array<double, 6> values = {45.0, 80.0, 9.0, 2e-4, 2e-4, 2e-4};
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i]->value = values[i];
  return model;
}

/// A square that nothing holds yet; every vertex of the mesh is seen where it lies at rest.
Capture capture_of_square(std::size_t frames) {
  Capture capture;
  capture.kind = "deforming_sheet";
  capture.title = "square";
  capture.specimen.area_density_kg_m2 = 0.15;
  capture.protocol.phases = {{"test", "other", std::nullopt}};
  capture.runs = {{1, ""}};
  for (std::size_t f = 0; f < frames; ++f) {
    capture.frame.push_back(static_cast<int>(f) + 1);
    capture.branch.push_back(2 * f < frames ? capture::Branch::load : capture::Branch::unload);
  }
  capture.run.assign(frames, 0);
  capture.phase.assign(frames, 0);
  capture.sheet.emplace();
  Sheet& sheet = *capture.sheet;
  const auto mesh =
      mechanics::grid_mesh({kSide, kSide, kSize_m, kSize_m}, mechanics::Diagonals::one).value();
  for (int n = 0; n < mesh.node_count(); ++n)
    sheet.material_m.push_back({mesh.material_m(0, n), mesh.material_m(1, n)});
  sheet.triangles = mesh.triangles;
  for (std::size_t f = 0; f < frames; ++f)
    for (const auto& [u, v] : sheet.material_m)
      sheet.position_m.insert(sheet.position_m.end(), {u, v, 0.0});
  sheet.sigma_m = 2e-5;
  return capture;
}

capture::ClipTrack clip_on(const std::string& id, double lo_u, double hi_u, std::size_t frames) {
  capture::ClipTrack clip;
  clip.id = id;
  clip.region_m = {{lo_u, 0.0}, {hi_u, 0.0}, {hi_u, kSize_m}, {lo_u, kSize_m}};
  clip.pose.resize(frames);
  return clip;
}

capture::RigidPose pose(const Eigen::Vector3d& position, const Eigen::Vector3d& turn) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(
      turn.norm(), turn.norm() > 0.0 ? turn.normalized().eval() : Eigen::Vector3d::UnitX().eval()));
  return {{position.x(), position.y(), position.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

/// Puts the equilibria of the sequence into the capture it came from: positions, the poses of free
/// clips, and the tension that balances each prescribed clip with a cord.
void simulate_into(Capture& capture) {
  Sheet& sheet = *capture.sheet;
  const CapturedSequence captured = sequence_from_capture(capture, same_grid()).value();
  const Sequence& sequence = captured.sequence;
  const model::Model model = cloth_model();
  const auto mesh_model = mechanics::MeshModel::make(model, sequence.cloth).value();
  Eigen::VectorXd parameters(6);
  parameters << 45.0, 80.0, 9.0, 2e-4, 2e-4, 2e-4;
  mechanics::State state = sequence.start;
  for (Eigen::Index n = 0; n < state.x.size() / 3; ++n)
    state.x[3 * n + 2] += 1e-4 * std::sin(40.0 * state.x[3 * n]);
  mechanics::EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const SequenceFrame& frame = sequence.frames[f];
    const auto b = static_cast<std::size_t>(frame.boundary);
    auto solver = EquilibriumSolver::make(mesh_model, sequence.boundaries[b]).value();
    prescribe(sequence, f, f == 0, state);
    mechanics::Loads loads = sequence.loads;
    loads.cord_force_N = frame.cord_force_N;
    const auto result = solver.solve(parameters, loads, state, options);
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_TRUE(result->is_good(options)) << describe(*result, options);
    for (std::size_t k = 0; k < sheet.vertex_count(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        sheet.position_m[sheet.at(f, k) + c] = state.x[static_cast<Eigen::Index>(3 * k + c)];
    for (std::size_t c = 0; c < sheet.clips.size(); ++c) {
      const Eigen::Quaterniond q(state.clips[c].rotation);
      const Eigen::Vector3d& at = state.clips[c].position_m;
      sheet.clips[c].pose[f] = {{at.x(), at.y(), at.z()}, {q.w(), q.x(), q.y(), q.z()}};
    }
    for (capture::CordTrack& cord : sheet.cords)
      for (std::size_t c = 0; c < sheet.clips.size(); ++c) {
        if (sheet.clips[c].id != cord.clip || sheet.clips[c].is_free) continue;
        const mechanics::Clip& clip = sequence.boundaries[b].clips[c];
        const Eigen::Vector3d pull =
            -(mechanics::reaction(clip, state.x, result->by_node, Eigen::Vector3d::Zero()).force_N +
              clip.mass_kg * loads.gravity_m_s2);
        const auto& d = cord.direction[f];
        cord.tension_N[f] = pull.dot(Eigen::Vector3d(d[0], d[1], d[2]));
      }
  }
}

/// Residuals at the parameters that the capture was simulated with, over all rows.
Eigen::VectorXd residuals_at_truth(const CapturedSequence& captured) {
  auto evaluator = SequenceEvaluator::make(cloth_model(), {captured.sequence}, {1, 1e-9});
  EXPECT_TRUE(evaluator) << evaluator.error().message;
  Eigen::VectorXd truth(6), residuals;
  truth << 45.0, 80.0, 9.0, 2e-4, 2e-4, 2e-4;
  EXPECT_EQ(evaluator->evaluate(truth, residuals, nullptr), mechanics::PathStatus::ok)
      << evaluator->failure();
  return residuals;
}

/// Pulled by a turned clip with a mass, whose cord leads a little upwards.
Capture pulled_square() {
  constexpr std::size_t kFrames = 4;
  Capture capture = capture_of_square(kFrames);
  Sheet& sheet = *capture.sheet;
  sheet.clips = {clip_on("fixed", 0.0, 0.013, kFrames), clip_on("moved", 0.0875, kSize_m, kFrames)};
  capture::ClipTrack& moved = sheet.clips[1];
  moved.mass_kg = 0.012;
  moved.grip = pose({-0.1, 0.0, 0.002}, {0.0, 0.0, 0.3});
  // where the grip puts the material back at (u, v, 0), and from there on
  const Eigen::Matrix3d grip_turn =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (std::size_t f = 0; f < kFrames; ++f) {
    const double share = 0.25 * (static_cast<double>(f) + 1.0);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.05 * share, Eigen::Vector3d::UnitX()).toRotationMatrix() *
        grip_turn.transpose();
    const Eigen::Vector3d at = Eigen::Vector3d(0.006 * share, 0.001 * share, 0.0) -
                               turn * Eigen::Vector3d(-0.1, 0.0, 0.002);
    const Eigen::Quaterniond q(turn);
    moved.pose[f] = {{at.x(), at.y(), at.z()}, {q.w(), q.x(), q.y(), q.z()}};
  }
  capture::CordTrack cord;
  cord.id = "pull";
  cord.clip = "moved";
  cord.sigma_N = 0.002;
  cord.tension_N.assign(kFrames, 1.0);
  cord.direction.assign(kFrames, {0.8, 0.0, 0.6});
  sheet.cords = {cord};
  return capture;
}

TEST(FromCapture, PrescribedClipsAndTheirForces) {
  Capture capture = pulled_square();
  simulate_into(capture);
  ASSERT_GT(capture.sheet->cords[0].tension_N[3], 0.1);  // newtons: the cloth is stretched
  capture.sheet->may_be_missing = true;
  capture.sheet->position_m[capture.sheet->at(1, 40) + 2] = kNaN;
  const auto captured = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(captured) << captured.error().message;
  const Sequence& sequence = captured->sequence;
  ASSERT_EQ(sequence.boundaries.size(), 1U);
  EXPECT_EQ(sequence.boundaries[0].clips[0].nodes.size(), 2U * kSide);
  EXPECT_EQ(sequence.boundaries[0].clips[1].nodes.size(), 2U * kSide);
  ASSERT_EQ(sequence.forces.size(), 1U);
  EXPECT_LT((sequence.forces[0].direction - Eigen::Vector3d(0.8, 0.0, 0.6)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(sequence.forces[0].sigma_N, 0.002);
  EXPECT_EQ(sequence.frames[0].block, 0);
  EXPECT_EQ(sequence.frames[3].block, 1);  // its branch is another one
  const CaptureUse& use = captured->use;
  EXPECT_EQ(use.in_clips, 4 * kSide);
  EXPECT_EQ(use.points, 5 * kSide);
  EXPECT_EQ(use.missing, 1);
  EXPECT_EQ(use.readings, 4 * 3 * 5 * kSide - 1);
  EXPECT_EQ(in_words(use),
            "45 of 81 vertices compared in 4 frames, 539 coordinates; left out: 36 vertices in "
            "clips, 1 coordinates not seen");
  // frames start where the sheet was seen: nodes in clips exactly, others nearly
  for (std::size_t f = 0; f < 4; ++f)
    for (std::size_t k = 0; k < capture.sheet->vertex_count(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        if (const double seen = capture.sheet->position_m[capture.sheet->at(f, k) + c];
            !std::isnan(seen)) {
          EXPECT_NEAR(sequence.frames[f].start->x[static_cast<Eigen::Index>(3 * k + c)], seen,
                      1e-4);
        }
  const Eigen::VectorXd residuals = residuals_at_truth(*captured);
  ASSERT_EQ(residuals.size(), use.readings + 4);
  EXPECT_LT(residuals.cwiseAbs().maxCoeff(), 1e-3);
}

TEST(FromCapture, ForcesAlongDirectionsThatAreAskedFor) {
  Capture capture = pulled_square();
  simulate_into(capture);
  // a cord that bears all of what the clip takes is seen along any direction
  Sheet& sheet = *capture.sheet;
  const auto own = sequence_from_capture(capture, same_grid()).value();
  FromCaptureOptions options = same_grid();
  options.forces = {{"moved", {0.0, 0.0, 2.0}, false}, {"moved", {1.0, 0.0, 0.0}, true}};
  const auto captured = sequence_from_capture(capture, options);
  ASSERT_TRUE(captured) << captured.error().message;
  ASSERT_EQ(captured->sequence.forces.size(), 2U);
  for (std::size_t f = 0; f < 4; ++f) {
    const Eigen::VectorXd& values = captured->sequence.frames[f].forces_N;
    const double tension = sheet.cords[0].tension_N[f];
    EXPECT_NEAR(own.sequence.frames[f].forces_N[0], tension, 1e-12);
    EXPECT_NEAR(values[0], 0.6 * tension, 1e-12);
    const Eigen::Vector3d along = captured->sequence.frames[f].clips[1].rotation.col(0);
    EXPECT_NEAR(values[1], tension * along.dot(Eigen::Vector3d(0.8, 0.0, 0.6)), 1e-12);
    EXPECT_GT(values[1], 0.1 * tension);
  }
  EXPECT_TRUE(captured->sequence.forces[1].turns_with_clip);
  EXPECT_EQ(own.sequence.forces[0].name, sheet.cords[0].id);
  EXPECT_EQ(captured->sequence.forces[0].name, "moved");
  EXPECT_EQ(captured->sequence.forces[1].name, "moved_2");
  EXPECT_NEAR(captured->sequence.forces[0].sigma_N, 0.6 * 0.002, 1e-12);
  // two cords, which turn with the clip: their plane, in the clip's frame
  capture::CordTrack other = sheet.cords[0];
  other.id = "across";
  for (std::size_t f = 0; f < 4; ++f) {
    const auto turn = captured->sequence.frames[f].clips[1].rotation;
    const auto put = [](capture::CordTrack& cord, std::size_t frame, const Eigen::Vector3d& d) {
      cord.direction[frame] = {d.x(), d.y(), d.z()};
    };
    put(sheet.cords[0], f, turn * Eigen::Vector3d(0.8, 0.6, 0.0));
    put(other, f, turn * Eigen::Vector3d(0.0, 1.0, 0.0));
    other.tension_N[f] = 0.5;
  }
  sheet.cords.push_back(other);
  const auto both = sequence_from_capture(capture, same_grid()).value();
  ASSERT_EQ(both.sequence.forces.size(), 2U);
  EXPECT_TRUE(both.sequence.forces[1].turns_with_clip);
  EXPECT_LT((both.sequence.forces[1].direction - Eigen::Vector3d(-0.6, 0.8, 0.0)).norm(), 1e-9);
  EXPECT_NEAR(both.sequence.frames[2].forces_N[0], sheet.cords[0].tension_N[2] + 0.6 * 0.5, 1e-9);
  EXPECT_NEAR(both.sequence.frames[2].forces_N[1], 0.8 * 0.5, 1e-9);
  EXPECT_NEAR(both.sequence.forces[0].sigma_N, 0.002 * std::hypot(1.0, 0.6), 1e-9);
  options.forces = {{"third", {1.0, 0.0, 0.0}, false}};
  EXPECT_EQ(sequence_from_capture(capture, options).error().message,
            "square: a force is asked for of clip \"third\", which is not there, or along no "
            "direction");
}

TEST(FromCapture, FramesLastAsLongAsTheClockSays) {
  Capture capture = pulled_square();
  FromCaptureOptions options = same_grid();
  const auto durations = [&] {
    const CapturedSequence captured = sequence_from_capture(capture, options).value();
    std::vector<double> all;
    for (const SequenceFrame& frame : captured.sequence.frames) all.push_back(frame.duration_s);
    return all;
  };
  EXPECT_EQ(durations(), (std::vector<double>{0.0, 0.0, 0.0, 0.0}));
  capture.time_s = {10.0, 11.5, 14.0, 14.25};
  EXPECT_EQ(durations(), (std::vector<double>{0.0, 1.5, 2.5, 0.25}));
  options.frames = {0, 2, 3};
  EXPECT_EQ(durations(), (std::vector<double>{0.0, 4.0, 0.25}));
  options.frames = {};
  capture.runs.push_back({2, ""});
  capture.run = {0, 0, 1, 1};
  capture.time_s = {10.0, 11.5, 0.0, 3.0};
  EXPECT_EQ(durations(), (std::vector<double>{0.0, 1.5, 0.0, 3.0}));
}

TEST(FromCapture, WhatIsNeverSeenIsHiddenInEveryFrame) {
  Capture capture = pulled_square();
  Sheet& sheet = *capture.sheet;
  sheet.may_be_missing = true;
  for (std::size_t f = 0; f < capture.frame_count(); ++f)
    for (std::size_t c = 0; c < 3; ++c) sheet.position_m[sheet.at(f, 40) + c] = kNaN;
  const auto captured = sequence_from_capture(capture, same_grid()).value();
  EXPECT_EQ(captured.use.never_seen, 1);
  EXPECT_NEAR(captured.sequence.spacing_m, kSize_m / (kSide - 1), 1e-12);
  for (const SequenceFrame& frame : captured.sequence.frames) {
    ASSERT_EQ(frame.hidden_m.size(), 1U);
    EXPECT_EQ(frame.hidden_m[0], Eigen::Vector2d(sheet.material_m[40][0], sheet.material_m[40][1]));
  }
}

TEST(FromCapture, AFreeClipMovesUnderItsCords) {
  Capture capture = pulled_square();
  Sheet& sheet = *capture.sheet;
  sheet.clips[1].is_free = true;
  sheet.clips[1].centre_of_mass_m = {0.0, 0.0, 0.0};
  capture::CordTrack& cord = sheet.cords[0];
  capture::CordTrack other = cord;
  other.id = "other";
  cord.attachment_m = {0.01, 0.02, 0.0};
  other.attachment_m = {-0.02, 0.09, 0.0};
  cord.tension_N = {0.4, 0.8, 1.2, 0.7};
  other.tension_N = {0.5, 0.9, 1.1, 0.6};
  sheet.cords = {cord, other};
  simulate_into(capture);
  EXPECT_GT(std::abs(sheet.clips[1].pose[2].position_m[0] - sheet.clips[1].pose[0].position_m[0]),
            1e-4);
  auto captured = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(captured) << captured.error().message;
  EXPECT_TRUE(captured->sequence.forces.empty());
  EXPECT_TRUE(captured->sequence.boundaries[0].clips[1].is_free);
  EXPECT_LT(residuals_at_truth(*captured).cwiseAbs().maxCoeff(), 1e-2);
  // a frame without its load cannot be solved
  sheet.cords[1].may_be_missing = true;
  sheet.cords[1].tension_N[1] = kNaN;
  captured = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(captured) << captured.error().message;
  EXPECT_EQ(captured->use.dropped_frames, std::vector<std::size_t>{1});
  EXPECT_EQ(captured->frame, (std::vector<std::size_t>{0, 2, 3}));
}

TEST(FromCapture, ATablesEdgeHoldsOtherNodesInEveryFrame) {
  constexpr std::size_t kFrames = 3;
  Capture capture = capture_of_square(kFrames);
  capture::SupportTrack table;
  table.id = "table";
  table.bears_above = false;
  table.edge_m = {0.08, 0.07, 0.06};
  for (std::size_t f = 0; f < kFrames; ++f)
    table.pose.push_back(pose({0.01 * static_cast<double>(f), 0.0, 0.0}, Eigen::Vector3d::Zero()));
  capture.sheet->supports = {table};
  simulate_into(capture);
  EXPECT_LT(capture.sheet->position_m[capture.sheet->at(2, kSide - 1) + 2], -1e-3);  // it hangs
  const auto captured = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(captured) << captured.error().message;
  const Sequence& sequence = captured->sequence;
  ASSERT_EQ(sequence.boundaries.size(), 3U);
  // seven, six and five lines lie on the table; the edge cuts the triangles before the next one
  EXPECT_EQ(sequence.boundaries[0].held.size(), 8U * kSide);
  EXPECT_EQ(sequence.boundaries[2].held.size(), 6U * kSide);
  EXPECT_NEAR(sequence.frames[2].held_m(0, 0), 0.02, 1e-12);
  EXPECT_EQ(captured->use.points, kSide * kSide);
  EXPECT_EQ(captured->use.held, 3 * kSide * (8 + 7 + 6));
  EXPECT_LT(residuals_at_truth(*captured).cwiseAbs().maxCoeff(), 1e-3);

  FromCaptureOptions only_on_table = same_grid();
  only_on_table.clamps_at_edge = false;
  const auto longer = sequence_from_capture(capture, only_on_table);
  ASSERT_TRUE(longer) << longer.error().message;
  EXPECT_EQ(longer->sequence.boundaries[0].held.size(), 7U * kSide);
  EXPECT_GT(residuals_at_truth(*longer).cwiseAbs().maxCoeff(), 1.0);
  // an edge along a line of nodes cuts no triangle
  capture.sheet->supports[0].edge_m[0] = 0.075;
  const auto on_line = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(on_line) << on_line.error().message;
  EXPECT_EQ(on_line->sequence.boundaries[0].held.size(), 7U * kSide);
}

TEST(FromCapture, SlackFramesAreLeftOutAndOthersThinned) {
  Capture capture = capture_of_square(12);
  Sheet& sheet = *capture.sheet;
  sheet.clips = {clip_on("fixed", 0.0, 0.0, 12), clip_on("moved", kSize_m, kSize_m, 12)};
  for (std::size_t f = 0; f < 12; ++f)
    sheet.clips[1].pose[f].position_m[0] = 0.001 * static_cast<double>(f);
  sheet.slack = capture::SlackRule{{"fixed", "moved"}, 0.0025};
  FromCaptureOptions options = same_grid();
  const auto taut = sequence_from_capture(capture, options);
  ASSERT_TRUE(taut) << taut.error().message;
  EXPECT_EQ(taut->use.slack_frames, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(taut->sequence.frames.size(), 9U);
  EXPECT_NE(in_words(taut->use).find("3 slack frames"), std::string::npos) << in_words(taut->use);
  options.most_frames = 5;
  const auto thinned = sequence_from_capture(capture, options);
  ASSERT_TRUE(thinned) << thinned.error().message;
  EXPECT_EQ(thinned->frame, (std::vector<std::size_t>{3, 5, 7, 9, 11}));
  EXPECT_EQ(thinned->use.thinned_frames, 4);
  sheet.slack->closer_than_m = 1.0;
  EXPECT_EQ(sequence_from_capture(capture, options).error().message,
            "square: no frame is left that is not slack");
}

TEST(FromCapture, ManyVerticesAreComparedWithACoarseMesh) {
  Capture capture = capture_of_square(2);
  Sheet& sheet = *capture.sheet;
  sheet.clips = {clip_on("fixed", 0.0, 0.0, 2)};
  FromCaptureOptions options = same_grid();
  options.nodes_u = 4;
  options.nodes_v = 5;
  options.most_points = 20;
  const auto thinned = sequence_from_capture(capture, options);
  ASSERT_TRUE(thinned) << thinned.error().message;
  EXPECT_EQ(thinned->use.points, 20);
  EXPECT_EQ(thinned->use.thinned, 8 * kSide - 20);
  EXPECT_EQ(thinned->sequence.cloth.mesh.node_count(), 20);
  // even: nowhere is a vertex farther from a compared one than two of its neighbours
  for (const auto& [u, v] : sheet.material_m) {
    double nearest = 1.0;
    for (const PointChannel& point : thinned->sequence.points)
      nearest = std::min(nearest, (point.material_m - Eigen::Vector2d(u, v)).norm());
    EXPECT_LT(nearest, 2.0 * kSize_m / (kSide - 1) + 1e-9);
  }
  options.most_points = 0;
  options.rectangle_m = {{0.0, 0.0}, {0.05, kSize_m}};
  EXPECT_EQ(sequence_from_capture(capture, options)->use.outside, 4 * kSide);
  options.nodes_v = 0;  // cells as those of a square of this area: 3 sqrt(1/2) along u, 3 sqrt(2)
  EXPECT_EQ(sequence_from_capture(capture, options)->sequence.cloth.mesh.node_count(), 3 * 5);
  options = same_grid();
  options.use_own_mesh = true;
  sheet.clips[0].region_m.clear();
  for (int j = 0; j < kSide; ++j) sheet.clips[0].vertices.push_back(kSide * j);
  const auto own = sequence_from_capture(capture, options);
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_EQ(own->sequence.cloth.mesh.triangle_count(), 2 * (kSide - 1) * (kSide - 1));
  EXPECT_EQ(own->sequence.boundaries[0].clips[0].nodes, sheet.clips[0].vertices);
  // the same vertices hold the nodes between them on a grid of another resolution
  options = same_grid();
  options.nodes_v = 14;
  EXPECT_EQ(sequence_from_capture(capture, options)->use.clip_nodes, std::vector<int>{14});
}

TEST(FromCapture, SaysWhatIsWrong) {
  const auto complaint = [](const Capture& capture, const FromCaptureOptions& options) {
    const auto captured = sequence_from_capture(capture, options);
    return captured ? "" : captured.error().message;
  };
  const Capture good = pulled_square();
  EXPECT_EQ(complaint(good, same_grid()), "");
  Capture bad = good;
  bad.sheet.reset();
  EXPECT_EQ(complaint(bad, same_grid()), "square: is not a capture of a deforming sheet");
  bad = good;
  bad.sheet->sigma_m = 0.0;
  EXPECT_EQ(
      complaint(bad, same_grid()),
      "square: the capture does not say how noisy its positions are (positions.sigma, in metres; "
      "the option sigma_m stands in for it)");
  FromCaptureOptions options = same_grid();
  options.unknown_sigma_m = 1e-4;
  EXPECT_EQ(complaint(bad, options), "");
  bad = good;
  bad.specimen.area_density_kg_m2.reset();
  EXPECT_EQ(complaint(bad, same_grid()),
            "square: there is gravity, but the specimen has neither a mass nor an area density");
  bad = good;
  bad.sheet->clips[0].region_m = {{0.001, 0.001}, {0.002, 0.001}, {0.002, 0.002}};
  EXPECT_EQ(complaint(bad, same_grid()),
            "square: clip \"fixed\" clamps no node of the simulated mesh; a finer one may have "
            "some there");
  bad = good;
  bad.sheet->clips[0].region_m[1][0] = bad.sheet->clips[0].region_m[2][0] = 0.09;
  EXPECT_EQ(complaint(bad, same_grid()),
            "square: clips \"fixed\" and \"moved\" clamp the same node of the simulated mesh");
  bad = good;
  for (auto& [u, v] : bad.sheet->material_m) u += 0.25 * v;
  EXPECT_EQ(complaint(bad, same_grid()),
            "square: the captured mesh fills 80 % of its rectangle, so a grid would be another "
            "specimen; its own mesh can be simulated");
  bad.sheet->triangles.clear();
  EXPECT_EQ(
      complaint(bad, same_grid()),
      "square: the capture has points without triangles, so no mesh of its own; an outline or a "
      "rectangle of the material must be given");
  bad = good;
  bad.sheet->triangles.clear();
  bad.sheet->outline_m = {{0.0, 0.0}, {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}};
  EXPECT_EQ(complaint(bad, same_grid()), "");
}

TEST(FromCapture, AnOutlineThatIsNoRectangleIsMeshed) {
  Capture capture = capture_of_square(1);
  capture.sheet->clips = {clip_on("fixed", 0.0, 0.0, 1)};
  capture.sheet->outline_m = {{0.0, 0.0}, {0.1, 0.0}, {0.06, 0.1}, {0.0, 0.1}};
  const auto captured = sequence_from_capture(capture, same_grid());
  ASSERT_TRUE(captured) << captured.error().message;
  const auto& mesh = captured->sequence.cloth.mesh;
  double area = 0.0;
  for (const double of_triangle : mechanics::triangle_areas_m2(mesh)) area += of_triangle;
  EXPECT_NEAR(area, 0.008, 1e-9);
  EXPECT_GT(mesh.node_count(), kSide * kSide / 2);
  EXPECT_LT(mesh.node_count(), 3 * kSide * kSide);
  EXPECT_GT(captured->use.outside, 5);
  EXPECT_GE(captured->use.clip_nodes[0], 4);
}

TEST(MaterialLocator, AnswersAsTheSlowWay) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-0.02, 0.12);
  const auto mesh = mechanics::grid_mesh({7, 12, 0.1, 0.08}, mechanics::Diagonals::both).value();
  const MaterialLocator locator(mesh);
  int found = 0;
  for (int k = 0; k < 2000; ++k) {
    Eigen::Vector2d place(anywhere(random), anywhere(random));
    if (k < mesh.node_count()) place = mesh.material_m.col(k);
    const auto one = locate(mesh, place);
    const auto other = locator.locate(place);
    ASSERT_EQ(one.has_value(), other.has_value());
    if (!one) continue;
    ++found;
    EXPECT_EQ(one->nodes, other->nodes);
    EXPECT_EQ(one->weight, other->weight);
  }
  EXPECT_GT(found, 500);
}

TEST(MeasuredStates, AreExactWhereTheSheetIsTurnedAndStretchedEvenly) {
  const auto mesh =
      mechanics::grid_mesh({6, 7, 0.1, 0.1}, mechanics::Diagonals::alternating).value();
  Eigen::Matrix<double, 3, 2> map;
  map << 1.1, 0.1, -0.2, 0.9, 0.3, 0.4;
  const MaterialLocator locator(mesh);
  std::vector<MaterialLocation> points;
  Eigen::Matrix3Xd seen(3, 5);
  const std::array<Eigen::Vector2d, 5> places = {
      {{0.011, 0.023}, {0.08, 0.031}, {0.05, 0.09}, {0.033, 0.06}, {0.07, 0.07}}};
  for (std::size_t k = 0; k < places.size(); ++k) {
    points.push_back(locator.locate(places[k]).value());
    seen.col(static_cast<Eigen::Index>(k)) = map * places[k];
  }
  seen(2, 4) = kNaN;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * mesh.node_count());
  std::vector<bool> is_fixed(static_cast<std::size_t>(mesh.node_count()), false);
  is_fixed[3] = true;
  x.segment<3>(9) = map * mesh.material_m.col(3);
  MeasuredStates(mesh, points).at(is_fixed, seen, x);
  for (int n = 0; n < mesh.node_count(); ++n)
    EXPECT_LT((x.segment<3>(3 * n) - map * mesh.material_m.col(n)).norm(), 1e-12) << n;
}

}  // namespace
}  // namespace tenter::estimation
