// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/scene/run.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "common/scene/document.h"
#include "common/scene/examples.h"

namespace tenter::mechanics {
namespace {

constexpr double kG = 9.81;

scene::Scene scene_of(const std::string& members) {
  auto scene = scene::parse_scene(
      R"({"schema": "tenter.scene", "version": 1, "name": "s", )" + members + "}", "test");
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value_or(scene::Scene());
}

scene::Scene shipped(const char* name) {
  return scene::parse_scene(scene::example_json(name).value(), name).value();
}

std::string grid(int nodes, double side_m) {
  return R"("mesh": {"kind": "grid", "nodes_u": )" + std::to_string(nodes) + R"(, "nodes_v": )" +
         std::to_string(nodes) + R"(, "length_u_m": )" + std::to_string(side_m) +
         R"(, "length_v_m": )" + std::to_string(side_m) + "}, \"area_density_kg_m2\": 0.2";
}

struct Walk {
  std::vector<SceneFrame> frames;
  SceneEnd end;
};

Walk walk(const scene::Scene& scene, const model::Model& model) {
  Walk result;
  auto run = SceneRun::make(scene, model);
  EXPECT_TRUE(run) << (run ? "" : run.error().message);
  if (!run) return result;
  const auto end =
      run->walk({[&result](const SceneFrame& frame) { result.frames.push_back(frame); }, {}});
  EXPECT_TRUE(end) << (end ? "" : end.error().message);
  if (end) result.end = *end;
  EXPECT_EQ(result.end.frames, static_cast<int>(result.frames.size()));
  for (const SceneFrame& frame : result.frames) {
    EXPECT_TRUE(frame.state.x.allFinite());
    EXPECT_TRUE(frame.term_energies_J.allFinite());
    EXPECT_EQ(frame.net_force_N <= scene.solver.tolerance_N, true) << frame.net_force_N;
  }
  return result;
}

Walk walk(const scene::Scene& scene, const char* model = "cloth_stvk") {
  return walk(scene, model::preset(model).value());
}

void expect_near(const Eigen::Vector3d& value, const Eigen::Vector3d& wanted, double tolerance) {
  EXPECT_LE((value - wanted).norm(), tolerance)
      << value.transpose() << " instead of " << wanted.transpose();
}

TEST(SceneRun, AHangingSquareIsCarriedByItsCorners) {
  scene::Scene scene = shipped("hanging_square");
  scene.solver.tolerance_N = 1e-8;  // sums over many nodes are compared below
  const Walk done = walk(scene);
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  ASSERT_EQ(static_cast<int>(done.frames.size()), scene.frame_count());
  const double cloth_N = 0.187 * 0.25 * kG;
  const double bar_N = 0.05 * kG;
  const auto sum = [](const SceneFrame& f) -> Eigen::Vector3d {
    return f.reactions[0].force_N + f.reactions[1].force_N;
  };
  ASSERT_GT(cloth_N, 0.1);
  expect_near(sum(done.frames[0]), {0, 0, -cloth_N}, 1e-5);
  expect_near(sum(done.frames.back()), {0, 0, -cloth_N - bar_N}, 1e-5);
  // the weight came in equal parts, and the corner went where it was told
  expect_near(sum(done.frames[12]), {0, 0, -cloth_N - 0.4 * bar_N}, 1e-5);
  expect_near(done.frames[5].state.clips[1].position_m, {0.475, 0, 0.5}, 1e-12);
  expect_near(done.frames.back().state.clips[1].position_m, {0.45, 0, 0.5}, 1e-12);
  for (const SceneFrame& f : done.frames) {
    EXPECT_EQ(f.stability, Stability::minimum);
    for (const int c : {0, 1}) {  // a clip is where its node is
      const int node = c == 0 ? 24 * 25 : 24 * 25 + 24;
      expect_near(f.state.clips[static_cast<std::size_t>(c)].position_m,
                  f.state.x.segment<3>(3 * node), 1e-15);
    }
  }
}

/// Work (J) of the four clips of a picture frame up to a frame; they bear nothing together.
double frame_work_J(const Walk& done, std::size_t last) {
  double work_J = 0.0;
  for (std::size_t i = 0; i <= last; ++i) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      const Wrench& now = done.frames[i].reactions[c];
      force += now.force_N;
      torque += now.torque_N_m + done.frames[i].state.clips[c].position_m.cross(now.force_N);
      if (i == 0) continue;
      // trapezoidal rule in the pose: the clip's middle, and its turn about z
      const Wrench& before = done.frames[i - 1].reactions[c];
      const Pose& p = done.frames[i - 1].state.clips[c];
      const Pose& q = done.frames[i].state.clips[c];
      const Eigen::Matrix3d turn = q.rotation * p.rotation.transpose();
      const double angle = std::atan2(turn(1, 0), turn(0, 0));
      work_J -= 0.5 * (now.force_N + before.force_N).dot(q.position_m - p.position_m) +
                0.5 * (now.torque_N_m.z() + before.torque_N_m.z()) * angle;
    }
    EXPECT_LE(force.norm(), 1e-4);
    EXPECT_LE(torque.norm(), 1e-5);
  }
  return work_J;
}

/// Rigid sides on hinges: what the material does on all of them together is nothing, and the work
/// done at the clips is the energy that the material has gained.
TEST(SceneRun, PictureFrameShearDoesAsMuchWorkAsTheMaterialHolds) {
  scene::Scene scene = shipped("picture_frame");
  const auto& mesh = std::get<scene::GridMesh>(scene.mesh);
  ASSERT_EQ(mesh.diagonals, "both");
  scene.start.noise_m = 0.0;  // stays flat: the work below is that of one smooth path
  scene.solver.check_minimum = false;
  for (scene::Motion& motion : scene.protocol[0].motions) motion.turn_rad[2] /= 4.0;
  const Walk done = walk(scene);
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  const double work_J = frame_work_J(done, done.frames.size() - 1);
  const double held_J = done.frames.back().term_energies_J.sum();
  ASSERT_GT(held_J, 1e-4);
  EXPECT_NEAR(work_J, held_J, 0.02 * held_J);
  // symmetric material, symmetric answer: left and right sides bear the same
  const auto& last = done.frames.back().reactions;
  ASSERT_GT(last[1].force_N.norm(), 0.01);
  EXPECT_NEAR(last[1].force_N.norm(), last[2].force_N.norm(), 0.02 * last[1].force_N.norm());
}

// Friction in shear: the way back gives less than the way there took, and what is missing is what
// the friction has taken.
TEST(SceneRun, PictureFrameShearToAndFroLosesTheWorkOfItsFriction) {
  scene::Scene scene = shipped("picture_frame");
  scene.start.noise_m = 0.0;
  scene.solver.check_minimum = false;
  for (scene::Motion& motion : scene.protocol[0].motions) motion.turn_rad[2] /= 4.0;
  scene::Phase back = scene.protocol[0];
  for (scene::Motion& motion : back.motions) {
    motion.turn_rad[2] = -motion.turn_rad[2];
    for (double& move : motion.move_m) move = -move;
  }
  scene.protocol = {scene.protocol[0], back};
  model::Model model = model::preset("cloth_stvk").value();
  model::Term friction = model.terms[0];
  friction.id = "shear_friction";
  friction.strain.name = "green_uv";
  friction.law = {};
  friction.law.name = "dahl";
  friction.law.parameters = model::default_parameters(*model::find_law("dahl"), 1);
  friction.law.parameters[0].value = 4.0;
  friction.law.parameters[3].value = 0.05;
  model.terms.push_back(friction);
  const Walk done = walk(scene, model);
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  const std::size_t there = done.frames.size() / 2, home = done.frames.size() - 1;
  const double out_J = frame_work_J(done, there), all_J = frame_work_J(done, home);
  const Eigen::VectorXd& at_home = done.frames[home].term_energies_J;
  const double lost_J = at_home[at_home.size() - 1];
  ASSERT_GT(out_J, 1e-4);
  EXPECT_GT(all_J, 0.1 * out_J);
  EXPECT_NEAR(all_J, at_home.sum(), 0.02 * out_J);
  EXPECT_NEAR(out_J, done.frames[there].term_energies_J.sum(), 0.02 * out_J);
  EXPECT_GT(lost_J, 0.9 * all_J);
}

TEST(SceneRun, AFreeClipRestsUnderItsCordsAndWeight) {
  scene::Scene scene = shipped("corner_pull");
  scene.solver.tolerance_N = 1e-8;  // sums over many nodes are compared below
  const Walk done = walk(scene);
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  const Eigen::Vector3d weight(0, 0, -0.005 * kG);
  const Eigen::Vector3d pulls[] = {{0, 0, -0.1}, {0, 0, -1.0}, {0.3, 0, -1.0}};
  const std::size_t at[] = {0, 5, 10};
  for (std::size_t i = 0; i < 3; ++i) {
    const SceneFrame& frame = done.frames[at[i]];
    const Eigen::Vector3d pull = pulls[i] + weight;
    expect_near(frame.reactions[1].force_N, -pull, 1e-5);
    const double cloth_N = 0.187 * 0.01 * kG;
    expect_near(frame.reactions[0].force_N, pull + Eigen::Vector3d(0, 0, -cloth_N), 1e-5);
  }
  // the free clip has gone down, then sideways
  const auto place = [&done](std::size_t frame) {
    return done.frames[frame].state.clips[1].position_m;
  };
  EXPECT_LT(place(5).z(), place(0).z() - 1e-3);
  EXPECT_GT(place(10).x(), place(5).x() + 1e-3);
}

/// A strip over the edge of a table: the clip bears all of its weight, and the tip ends lower, the
/// softer the bending is.
TEST(SceneRun, AStripBendsOverATableEdge) {
  const scene::Scene scene = shipped("table_edge");
  double fall_m[2];
  for (const int soft : {0, 1}) {
    model::Model model = model::preset("cloth_stvk").value();
    for (model::Term& term : model.terms)
      if (term.id.starts_with("bend"))
        for (model::Parameter& p : term.law.parameters) p.value *= soft == 1 ? 5.0 : 20.0;
    auto run = SceneRun::make(scene, model);
    ASSERT_TRUE(run);
    SceneFrame last;
    const auto end = run->walk({[&last](const SceneFrame& f) { last = f; }, {}});
    ASSERT_TRUE(end);
    ASSERT_EQ(end->how, SceneEnd::How::complete) << end->reason;
    const double weight_N = 0.187 * 0.16 * 0.02 * kG;
    ASSERT_GT(weight_N, 1e-3);
    expect_near(last.reactions[0].force_N, {0, 0, -weight_N}, 1e-4 * weight_N + 1e-6);
    fall_m[soft] = -last.state.x[3 * 40 + 2];
  }
  EXPECT_GT(fall_m[0], 0.005);
  EXPECT_GT(fall_m[1], 1.2 * fall_m[0]);
  EXPECT_LT(fall_m[1], 0.1);
}

TEST(SceneRun, ABulgeBearsPressureTimesArea) {
  const Walk done = walk(scene_of(grid(13, 0.1) + R"(, "gravity_m_s2": [0, 0, 0],
    "start": {"noise_m": 1e-5}, "pressure": {"pressure_Pa": 20},
    "clips": [{"id": "rim", "nodes": ["left", "right", "top", "bottom"]}],
    "protocol": [{"name": "inflate", "frames": 3, "pressure_Pa": 400}])"));
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  expect_near(done.frames[0].reactions[0].force_N, {0, 0, 20 * 0.01}, 1e-5);
  expect_near(done.frames.back().reactions[0].force_N, {0, 0, 400 * 0.01}, 1e-5);
  EXPECT_GT(done.frames.back().state.x[3 * (6 * 13 + 6) + 2], 0.005);
}

TEST(SceneRun, ClothLiesOnAnObstacleAndNotInIt) {
  const Walk done = walk(scene_of(grid(11, 0.2) + R"(,
    "start": {"noise_m": 1e-4},
    "clips": [{"id": "sides", "nodes": ["left", "right"]}],
    "obstacles": [{"kind": "cylinder", "point_m": [0.1, 0, -0.03], "axis": [0, 2, 0],
                   "radius_m": 0.03}],
    "protocol": [{"name": "down", "frames": 4, "motions": [{"clip": "sides",
                  "move_m": [0, 0, -0.04]}]}])"));
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  const Eigen::VectorXd& x = done.frames.back().state.x;
  double nearest_m = 1.0;
  for (int n = 0; n < 121; ++n)
    nearest_m = std::min(nearest_m, std::hypot(x[3 * n] - 0.1, x[3 * n + 2] + 0.03) - 0.03);
  EXPECT_GE(nearest_m, -2e-6);
  EXPECT_LE(nearest_m, 1e-5);
  // the cylinder carries what the clip does not, and more than the cloth weighs
  EXPECT_GT(done.frames.back().reactions[0].force_N.z(), 0.01);
}

TEST(SceneRun, ABodyBearsItsWeightAndAForce) {
  const Walk done = walk(scene_of(R"("mesh": {"kind": "box", "cells": [6, 2, 2],
    "size_m": [0.06, 0.02, 0.02]}, "density_kg_m3": 1000, "start": {"gravity_factor": 0},
    "clips": [{"id": "wall", "nodes": "left"}],
    "forces": [{"id": "tip", "nodes": "right", "force_N": [0, 0, 0]}],
    "protocol": [{"name": "weigh", "frames": 2, "gravity_factor": 1},
                 {"name": "push", "frames": 2, "forces": [{"force": "tip",
                  "force_N": [0.1, 0.2, 0]}]}])"),
                         "solid_neo_hookean");
  ASSERT_EQ(done.end.how, SceneEnd::How::complete) << done.end.reason;
  const double weight_N = 0.06 * 0.02 * 0.02 * 1000 * kG;
  expect_near(done.frames[2].reactions[0].force_N, {0, 0, -weight_N}, 1e-5);
  expect_near(done.frames[4].reactions[0].force_N, {0.1, 0.2, -weight_N}, 1e-5);
  ASSERT_FALSE(done.frames[4].strains.empty());
  EXPECT_EQ(done.frames[4].strains[0].kind, ElementKind::hexahedron_point);
}

/// With few iterations the start fails at once, and is reached with its loads coming in steps.
TEST(SceneRun, AStartThatFailsAtOnceIsLoadedInSteps) {
  scene::Scene scene = shipped("corner_pull");
  scene.protocol.clear();
  scene.clips[1].cords[0].force_N = {0, 0, -3};
  scene.solver.max_iterations = 100;
  const Walk easy = walk(scene);
  ASSERT_EQ(easy.end.how, SceneEnd::How::complete) << easy.end.reason;
  EXPECT_EQ(easy.frames[0].steps, 1);
  ASSERT_GT(easy.frames[0].iterations, 3);
  scene.solver.max_iterations = easy.frames[0].iterations - 1;
  scene.solver.most_halvings = 0;
  EXPECT_EQ(walk(scene).end.how, SceneEnd::How::failed);
  scene.solver.most_halvings = 8;
  const Walk cut = walk(scene);
  ASSERT_EQ(cut.end.how, SceneEnd::How::complete) << cut.end.reason;
  EXPECT_GT(cut.frames[0].steps, 1);
  expect_near(cut.frames[0].reactions[1].force_N, easy.frames[0].reactions[1].force_N, 1e-3);
}

TEST(SceneRun, WhatCannotBeReachedEndsTheWalkWithAReason) {
  // a hanging square without a clip
  const Walk loose = walk(scene_of(grid(5, 0.1)));
  EXPECT_EQ(loose.end.how, SceneEnd::How::failed);
  EXPECT_EQ(loose.end.frames, 0);
  EXPECT_NE(loose.end.reason.find("frame 0, the start"), std::string::npos) << loose.end.reason;
  EXPECT_NE(loose.end.reason.find("nothing holds it"), std::string::npos) << loose.end.reason;

  // frames that the iterations do not suffice for: those before are kept
  scene::Scene far = scene_of(grid(9, 0.1) + R"(, "gravity_m_s2": [0, 0, 0],
    "clips": [{"id": "a", "nodes": "left"}, {"id": "b", "nodes": "right"}],
    "solver": {"max_iterations": 4, "most_halvings": 1},
    "protocol": [{"name": "little", "frames": 2, "motions": [{"clip": "b",
                  "move_m": [1e-4, 0, 0]}]},
                 {"name": "much", "frames": 1, "motions": [{"clip": "b", "move_m": [-0.06, 0, 0.04],
                  "turn_rad": [2, 0, 1]}]}])");
  const Walk stuck = walk(far);
  EXPECT_EQ(stuck.end.how, SceneEnd::How::failed);
  EXPECT_EQ(stuck.end.frames, 3);
  EXPECT_NE(stuck.end.reason.find("frame 3, 100 % into phase 'much'"), std::string::npos)
      << stuck.end.reason;
  // with more halvings the same iterations suffice
  far.solver.most_halvings = 12;
  far.solver.max_iterations = 25;
  const Walk cut = walk(far);
  ASSERT_EQ(cut.end.how, SceneEnd::How::complete) << cut.end.reason;
  EXPECT_GT(cut.frames.back().steps, 1);
}

TEST(SceneRun, SaysWhatDoesNotFitTogether) {
  const auto complaint = [](const std::string& members, const char* model = "cloth_stvk") {
    const auto run = SceneRun::make(scene_of(members), model::preset(model).value());
    if (run) return std::string("made");
    EXPECT_EQ(run.error().kind, ErrorKind::bad_input);
    return run.error().message;
  };
  const std::string cloth = grid(5, 0.1);
  const auto starts = [](const std::string& text, const std::string& with) {
    EXPECT_TRUE(text.starts_with(with)) << text;
  };
  starts(complaint(cloth, "solid_stvk"), "model: ");
  starts(complaint(cloth + R"(, "clips": [{"id": "a", "nodes": {"box_m": [[1, 1], [2, 2]]}}])"),
         "clips[0].nodes: no node of the mesh is chosen");
  starts(complaint(cloth + R"(, "clips": [{"id": "a", "nodes": "left"},
                                          {"id": "b", "nodes": "top"}])"),
         "clips: clip \"b\" holds node 20, which is held already");
  starts(complaint(cloth + R"(, "clips": [{"id": "a", "nodes": "left", "free": true}])"),
         "clips: clip \"a\" is free, but its nodes");
  starts(complaint(cloth + R"(, "pressure": {"pressure_Pa": 1})"),
         "pressure: the surface is open at node");
  starts(complaint(cloth + R"(, "weights": [{"id": "w", "nodes": [77], "mass_kg": 1}])"),
         "weights[0].nodes: node 77 is chosen");
  starts(complaint(cloth + R"(, "clips": [{"id": "a", "nodes": "all"}])"), "every node is held");
  starts(complaint(R"("mass_kg": 1, "mesh": {"kind": "file", "path": "a.obj"})"), "mesh: ");
}

TEST(SceneRun, StopsWhenAskedToAndRepeatsItselfToTheLastBit) {
  const scene::Scene scene = shipped("hanging_square");
  auto run = SceneRun::make(scene, model::preset("cloth_stvk").value());
  ASSERT_TRUE(run);
  int seen = 0;
  const auto end =
      run->walk({[&seen](const SceneFrame&) { ++seen; }, [](int frame, int) { return frame < 4; }});
  ASSERT_TRUE(end);
  EXPECT_EQ(end->how, SceneEnd::How::stopped);
  EXPECT_EQ(seen, 4);
  const Walk one = walk(scene);
  const Walk two = walk(scene);
  ASSERT_EQ(one.frames.size(), two.frames.size());
  for (std::size_t i = 0; i < one.frames.size(); ++i) {
    EXPECT_EQ(one.frames[i].state.x, two.frames[i].state.x);
    EXPECT_EQ(one.frames[i].reactions[0].force_N, two.frames[i].reactions[0].force_N);
  }
}

}  // namespace
}  // namespace tenter::mechanics
