// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes with dynamics: frames are instants of a motion.
#include <gtest/gtest.h>

#include <cmath>

#include "common/model/presets.h"
#include "common/scene/document.h"
#include "common/scene/examples.h"
#include "server/mechanics/scene/run.h"

namespace tenter::mechanics {
namespace {

struct TimedWalk {
  std::vector<SceneFrame> frames;
  SceneEnd end;
};

/// A square of 0.1 m, horizontal, with these members besides.
Expected<scene::Scene> parsed_scene(const std::string& members) {
  return scene::parse_scene(
      R"({"schema": "tenter.scene", "version": 1, "name": "s", "mesh": {"kind": "grid",
          "nodes_u": 6, "nodes_v": 6, "length_u_m": 0.1, "length_v_m": 0.1},
          "area_density_kg_m2": 0.2, )" +
          members + "}",
      "test");
}

TimedWalk walk(const std::string& members) {
  TimedWalk result;
  const auto scene = parsed_scene(members);
  EXPECT_TRUE(scene) << scene.error().message;
  if (!scene) return result;
  auto run = SceneRun::make(*scene, model::preset("cloth_stvk").value());
  EXPECT_TRUE(run) << (run ? "" : run.error().message);
  if (!run) return result;
  const auto end =
      run->walk({[&](const SceneFrame& frame) { result.frames.push_back(frame); }, {}});
  EXPECT_TRUE(end) << (end ? "" : end.error().message);
  if (end) result.end = *end;
  EXPECT_EQ(result.end.how, SceneEnd::How::complete) << result.end.reason;
  EXPECT_EQ(static_cast<int>(result.frames.size()), scene->frame_count());
  return result;
}

const std::string kHeld = R"("clips": [{"id": "bar", "nodes": "top"}], )";

/// What the sheet has, and what damping took, is what it began with.
TEST(SceneMotion, EnergyIsAccountedFor) {
  const TimedWalk done = walk(kHeld + R"("dynamics": {"step_s": 0.0005, "damping_s": 0.05},
      "protocol": [{"name": "fall", "frames": 10, "duration_s": 0.1}])");
  const SceneFrame& first = done.frames.front();
  const SceneFrame& last = done.frames.back();
  EXPECT_EQ(first.instant->kinetic_J, 0.0);
  EXPECT_NEAR(last.instant->time_s, 0.1, 1e-12);
  EXPECT_EQ(last.steps, 20);
  EXPECT_GT(last.instant->error_m, 0.0);
  const auto damped_J = [&](const SceneFrame& frame) {
    // the preset's terms, then the damping of those of one strain
    double sum = 0.0;
    const Eigen::Index own = static_cast<Eigen::Index>(model::preset("cloth_stvk")->terms.size());
    for (Eigen::Index t = own; t < frame.term_energies_J.size(); ++t)
      sum += frame.term_energies_J[t];
    return sum;
  };
  const double fallen_J = first.energy_J - last.energy_J;
  ASSERT_GT(fallen_J, 1e-5);
  EXPECT_GT(damped_J(last), 0.01 * fallen_J);
  EXPECT_NEAR(last.instant->kinetic_J + damped_J(last), fallen_J, 0.02 * fallen_J);
  // the bar bears the weight and what the fall asks for: as an impulse
  double impulse_N_s = 0.0;
  for (std::size_t f = 1; f < done.frames.size(); ++f)
    impulse_N_s += 0.01 * done.frames[f].reactions[0].force_N.z();
  EXPECT_LT(impulse_N_s, 0.0);
}

TEST(SceneMotion, FromRestItStays) {
  const TimedWalk done = walk(kHeld + R"("start": {"place": "vertical", "noise_m": 1e-4},
      "dynamics": {"step_s": 0.01, "start": "equilibrium", "scheme": "implicit_euler"},
      "protocol": [{"name": "wait", "frames": 5, "duration_s": 0.5}])");
  const double side_m = 0.1;
  const double moved_m =
      (done.frames.back().state.x - done.frames.front().state.x).lpNorm<Eigen::Infinity>();
  EXPECT_LT(moved_m, 1e-3 * side_m);
  const double weight_N = 9.81 * 0.2 * side_m * side_m;
  EXPECT_NEAR(done.frames.back().reactions[0].force_N.z(), -weight_N, 1e-3 * weight_N);
  EXPECT_NEAR(done.frames.front().reactions[0].force_N.z(), -weight_N, 1e-3 * weight_N);
}

/// The clip turns and the sphere rises through the middle of the sheet: both are where they should
/// be, and no node is inside.
TEST(SceneMotion, ClipsAndObstaclesFollowTheScript) {
  const TimedWalk done = walk(kHeld + R"("gravity_m_s2": [0, 0, 0],
      "obstacles": [{"kind": "sphere", "point_m": [0.05, 0.03, -0.03], "radius_m": 0.02}],
      "dynamics": {"step_s": 0.004, "scheme": "implicit_euler", "damping_s": 0.005},
      "protocol": [{"name": "turn", "frames": 5, "duration_s": 0.1,
                    "motions": [{"clip": "bar", "turn_rad": [0, 0, 0.5]}]},
                   {"name": "rise", "frames": 5, "duration_s": 0.1,
                    "obstacles": [{"obstacle": 0, "move_m": [0, 0, 0.03]}]}])");
  const SceneFrame& last = done.frames.back();
  EXPECT_NEAR(std::atan2(last.state.clips[0].rotation(1, 0), last.state.clips[0].rotation(0, 0)),
              0.5, 1e-12);
  EXPECT_EQ(last.levels.obstacle_move_m[0], Eigen::Vector3d(0.0, 0.0, 0.03));
  EXPECT_NEAR(last.instant->time_s, 0.2, 1e-12);
  const Sphere sphere{{0.05, 0.03, 0.0}, 0.02};
  double highest_m = 0.0;
  for (Eigen::Index n = 0; n < last.state.x.size(); n += 3) {
    EXPECT_GE(gap(sphere, last.state.x.segment<3>(n)).value_m, -1e-6);
    highest_m = std::max(highest_m, last.state.x[n + 2]);
  }
  EXPECT_GT(highest_m, 0.01) << "it lies on the sphere";
}

TEST(SceneMotion, TheShippedSquareSwings) {
  const auto scene = scene::parse_scene(scene::example_json("swinging_square").value(), "shipped");
  ASSERT_TRUE(scene) << scene.error().message;
  auto run = SceneRun::make(*scene, model::preset("cloth_stvk").value());
  ASSERT_TRUE(run) << run.error().message;
  double lowest_m = 0.0, fastest_J = 0.0, first_J = 0.0;
  SceneHooks hooks;
  hooks.on_frame = [&](const SceneFrame& frame) {
    const double total_J = frame.energy_J + frame.instant->kinetic_J;
    if (frame.number == 0) first_J = total_J;
    if (frame.phase <= 0) {
      EXPECT_LE(total_J, first_J + 1e-6) << frame.number;
    }
    fastest_J = std::max(fastest_J, frame.instant->kinetic_J);
    for (Eigen::Index n = 2; n < frame.state.x.size(); n += 3)
      lowest_m = std::min(lowest_m, frame.state.x[n]);
  };
  const auto end = run->walk(hooks);
  ASSERT_TRUE(end) << end.error().message;
  EXPECT_EQ(end->how, SceneEnd::How::complete) << end->reason;
  EXPECT_EQ(end->frames, 76);
  EXPECT_LT(lowest_m, -0.4) << "it hangs down half a metre";
  EXPECT_GT(fastest_J, 0.05);
}

/// The upper edge is turned down beside the lower part, nearer than the thickness.
TEST(SceneMotion, ASheetKeepsOffItself) {
  const TimedWalk done = walk(R"("start": {"place": "vertical"}, "clips": [
        {"id": "low", "nodes": {"box_m": [[0, 0], [0.1, 0.03]]}},
        {"id": "high", "nodes": "top"}],
      "gravity_m_s2": [0, 0, 0],
      "dynamics": {"step_s": 0.004, "scheme": "implicit_euler", "self_contact_m": 0.004},
      "protocol": [{"name": "fold", "frames": 20, "duration_s": 0.4, "motions":
          [{"clip": "high", "turn_rad": [3.1, 0, 0], "about_m": [0.05, 0, 0.05]}]}])");
  const Cloth cloth = cloth_of_grid({6, 6, 0.1, 0.1}, Diagonals::alternating).value();
  auto contact = SelfContact::make(cloth.mesh, 0.004, 1.0).value();
  double nearest_m = 0.004;
  for (const SceneFrame& frame : done.frames)
    nearest_m = std::min(nearest_m, contact.nearest_m(frame.state.x));
  EXPECT_GT(nearest_m, 0.0);
  EXPECT_LT(nearest_m, 0.0025) << "the clips end 2.1 mm apart";
}

TEST(SceneMotion, SaysWhatDoesNotFit) {
  const std::string phase = R"("protocol": [{"name": "p", "frames": 1)";
  for (const auto& [members, says] :
       {std::pair{R"("dynamics": {}, )" + phase + "}]", "duration_s"},
        std::pair{phase + R"(, "duration_s": 1}])", "dynamics"},
        std::pair{R"("dynamics": {"step_s": 0}, )" + phase + R"(, "duration_s": 1}])",
                  "dynamics.step_s"},
        std::pair{R"("dynamics": {"self_contact_m": 0.001, "linearised": true}, )" + phase +
                      R"(, "duration_s": 1}])",
                  "linearised"},
        std::pair{R"("dynamics": {"scheme": "rk4"}, )" + phase + R"(, "duration_s": 1}])", "bdf2"},
        std::pair{R"("dynamics": {}, )" + phase +
                      R"(, "duration_s": 1, "obstacles": [{"obstacle": 0, "move_m": [0, 0, 1]}]}])",
                  "obstacle"}}) {
    const auto scene = parsed_scene(members);
    ASSERT_FALSE(scene) << members;
    EXPECT_NE(scene.error().message.find(says), std::string::npos) << scene.error().message;
  }
}

}  // namespace
}  // namespace tenter::mechanics
