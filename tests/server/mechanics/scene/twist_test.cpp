// SPDX-License-Identifier: GPL-3.0-or-later
// A sleeve that is twisted and back, coarse: what friction leaves of its wrinkles (thesis fig.
// 5.13). The whole experiments are the shipped scenes.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>

#include "common/model/presets.h"
#include "common/scene/document.h"
#include "server/mechanics/contact/crossings.h"
#include "server/mechanics/scene/run.h"

namespace tenter::mechanics {
namespace {

const char* const kSleeve = R"({
  "schema": "tenter.scene", "version": 1, "name": "sleeve",
  "mesh": {"kind": "tube", "nodes_around": 20, "nodes_along": 12, "radius_m": 0.04, "length_m": 0.15},
  "area_density_kg_m2": 0.143, "gravity_m_s2": [-9.81, 0, 0], "start": {"noise_m": 1e-5, "seed": 3},
  "clips": [{"id": "low", "nodes": "bottom"}, {"id": "high", "nodes": "top"}],
  "obstacles": [{"kind": "cylinder", "point_m": [0, 0, 0], "axis": [0, 0, 1], "radius_m": 0.038}],
  "dynamics": {"step_s": 0.01, "damping_s": 0.01},
  "protocol": [
    {"name": "hang", "frames": 1, "duration_s": 0.1},
    {"name": "twist", "frames": 1, "duration_s": 0.15, "motions": [{"clip": "low", "turn_rad": [0, 0, 1.2]}]},
    {"name": "untwist", "frames": 1, "duration_s": 0.15, "motions": [{"clip": "low", "turn_rad": [0, 0, -1.2]}]},
    {"name": "settle", "frames": 1, "duration_s": 0.5}]})";

/// rms of the change of all bending strains, over three: 1/m.
double curvature_1_m(const SceneFrame& from, const SceneFrame& to) {
  double sum = 0.0, area = 0.0;
  for (std::size_t s = 0; s < from.strains.size(); ++s) {
    const TermStrains& strains = from.strains[s];
    if (strains.kind != ElementKind::hinge) continue;
    for (std::size_t e = 0; e < strains.element.size(); ++e) {
      sum += strains.measure[e] * std::pow((to.strains[s].strain[e] - strains.strain[e]) / 3.0, 2);
      area += strains.measure[e];
    }
  }
  return std::sqrt(sum / area);
}

struct Left {
  double twisted_1_m = 0.0, left_1_m = 0.0;
};

Left twisted_and_back(bool has_friction) {
  const auto scene = scene::parse_scene(kSleeve, "sleeve");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  auto cotton = model::preset("cotton").value();
  if (!has_friction)
    std::erase_if(cotton.terms, [](const model::Term& t) { return t.law.name == "dahl"; });
  auto run = SceneRun::make(*scene, cotton);
  EXPECT_TRUE(run) << (run ? "" : run.error().message);
  std::vector<SceneFrame> frames;
  const auto end = run->walk({[&](const SceneFrame& frame) { frames.push_back(frame); }, {}});
  EXPECT_TRUE(end && end->how == SceneEnd::How::complete) << (end ? end->reason : "");
  if (frames.size() != 5) return {};
  return {curvature_1_m(frames[1], frames[2]), curvature_1_m(frames[1], frames[4])};
}

TEST(SceneTwist, LeavesWrinklesWithFrictionOnly) {
  const Left friction = twisted_and_back(true), elastic = twisted_and_back(false);
  EXPECT_GT(friction.twisted_1_m, 5.0);
  EXPECT_GT(elastic.twisted_1_m, 5.0);
  EXPECT_GT(friction.left_1_m, 0.02 * friction.twisted_1_m);
  EXPECT_LT(elastic.left_1_m, 0.1 * friction.left_1_m);
}

/// An empty sleeve, wrung by nearly a turn: its folds meet edge on edge.
TEST(SceneTwist, ASleeveThatIsWrungDoesNotPassThroughItself) {
  int crossed[2] = {};
  for (const bool keeps_apart : {false, true}) {
    std::string text = kSleeve;
    const auto put = [&text](const std::string& instead_of, const std::string& with) {
      const std::size_t at = text.find(instead_of);
      ASSERT_NE(at, std::string::npos) << instead_of;
      text.replace(at, instead_of.size(), with);
    };
    put(R"("obstacles": [{"kind": "cylinder", "point_m": [0, 0, 0], "axis": [0, 0, 1], "radius_m": 0.038}],)",
        "");
    put(R"("step_s": 0.01, "damping_s": 0.01)",
        std::string(R"("step_s": 0.005, "damping_s": 0.02, "self_contact_m": )") +
            (keeps_apart ? "0.003" : "0"));
    put(R"("frames": 1, "duration_s": 0.15, "motions": [{"clip": "low", "turn_rad": [0, 0, 1.2]}]},
    {"name": "untwist", "frames": 1, "duration_s": 0.15, "motions": [{"clip": "low", "turn_rad": [0, 0, -1.2]}]},
    {"name": "settle", "frames": 1, "duration_s": 0.5}])",
        R"("frames": 10, "duration_s": 0.2, "motions": [{"clip": "low", "turn_rad": [0, 0, 2.4]}]}])");
    const auto scene = scene::parse_scene(text, "sleeve");
    ASSERT_TRUE(scene) << scene.error().message;
    auto run = SceneRun::make(*scene, model::preset("cotton").value());
    ASSERT_TRUE(run) << run.error().message;
    const SurfaceMesh& mesh = std::get<Cloth>(run->body().mesh).mesh;
    const auto end = run->walk(
        {[&](const SceneFrame& frame) { crossed[keeps_apart] += crossings(mesh, frame.state.x); },
         {}});
    ASSERT_TRUE(end && end->how == SceneEnd::How::complete) << (end ? end->reason : "");
  }
  EXPECT_GT(crossed[0], 20);
  EXPECT_EQ(crossed[1], 0);
}

/// A support has a place, and a tube has each place of its seam twice.
TEST(SceneTwist, RefusesSupportsOnATube) {
  const auto scene = scene::parse_scene(kSleeve, "sleeve");
  ASSERT_TRUE(scene);
  auto cotton = model::preset("cotton").value();
  cotton.fields.push_back({"field", 2, {0.0, 0.0}, 0.05});
  cotton.terms.front().support = {"rbf", "field", 1};
  const auto run = SceneRun::make(*scene, cotton);
  ASSERT_FALSE(run);
  EXPECT_NE(run.error().message.find("seam"), std::string::npos) << run.error().message;
}

}  // namespace
}  // namespace tenter::mechanics
