// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/experiment/curves.h"
#include "common/experiment/experiment_json.h"
#include "common/experiment/measures.h"
#include "common/experiment/moments.h"

namespace tenter::experiment {
namespace {

/// Two triangles with a hinge between them, a clip that goes around a square of 2 by 3 in x and y
/// while its force turns with it: four phases of one frame each.
frames::FrameSet square_run() {
  frames::FrameSet run;
  run.nodes = 4;
  run.material_m = {0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.1, 0.2};
  run.elements = {{"triangle", 3, {0, 1, 2, 1, 3, 2}}, {"hinge", 4, {1, 2, 0, 3}}};
  run.phases = {"right", "up", "left", "down"};
  run.clips = {"other", "hand"};
  run.phase = {-1, 0, 1, 2, 3};
  run.phase_share = {1.0, 1.0, 1.0, 1.0, 1.0};
  const double x[] = {0.0, 2.0, 2.0, 0.0, 0.0}, y[] = {0.0, 0.0, 3.0, 3.0, 0.0};
  for (int f = 0; f < 5; ++f) {
    for (const double v : {9.0, 9.0, 9.0}) run.clip_position_m.push_back(v);
    for (const double v : {1.0, 1.0, 1.0}) run.force_N.push_back(v);
    for (const double v : {x[f], y[f], 0.0}) run.clip_position_m.push_back(v);
    // F = (5 y, 0, 0): around the square -F does 5 times its area
    for (const double v : {5.0 * y[f], 0.0, 0.0}) run.force_N.push_back(v);
    for (int n = 0; n < 4; ++n)
      for (const double v :
           {0.1 * n, 0.01 * f + 0.02 * (n % 2), 1.2345678e-4 + 1e-3 * (n == 3) * f})
        run.position_m.push_back(v);
  }
  run.strains = {{"weft", "green_u", "triangle", "1", {1.0, 3.0}, {{}}},
                 {"bend", "bend_u", "hinge", "1/m", {0.5}, {{}}}};
  run.strains[0].values[0] = {0.0, 0.0, 0.4, 0.2, 0.0, 0.0, 0.0, 0.0, 0.1, -0.1};
  run.strains[1].values[0] = {0.0, 30.0, 60.0, 90.0, -12.0};
  return run;
}

scene::Measure measure(const std::string& kind, const std::string& strain,
                       const std::string& at = "") {
  scene::Measure m;
  m.id = m.kind = kind;
  m.strain = strain;
  m.clip = "hand";
  m.at = at;
  m.width_m = 0.2;
  return m;
}

double value_of(const scene::Measure& m, const frames::FrameSet& run) {
  const auto value = measured(m, run, run);
  EXPECT_TRUE(value) << (value ? "" : value.error().message);
  return value && value->number ? *value->number : NAN;
}

TEST(Measures, StrainsAreMeansOverWhatElementsStandFor) {
  const frames::FrameSet run = square_run();
  EXPECT_DOUBLE_EQ(value_of(measure("mean_strain", "green_u", "right"), run), 0.25);
  EXPECT_DOUBLE_EQ(value_of(measure("rms_strain", "green_u", "right"), run),
                   std::sqrt((0.16 + 3.0 * 0.04) / 4.0));
  EXPECT_DOUBLE_EQ(value_of(measure("mean_strain", "green_u"), run), -0.05);
  EXPECT_DOUBLE_EQ(value_of(measure("rms_curvature", "bend_u", "left"), run), 30.0);
  EXPECT_DOUBLE_EQ(value_of(measure("rms_curvature", "bend_u", "start"), run), 0.0);
  EXPECT_EQ(measured(measure("rms_curvature", "bend_u"), run, run)->unit, "1/m");
  EXPECT_FALSE(measured(measure("rms_curvature", "green_u"), run, run));
  EXPECT_FALSE(measured(measure("rms_strain", "bend_v"), run, run));
}

TEST(Measures, WorkOfAClosedPathIsTheLoopsArea) {
  const frames::FrameSet run = square_run();
  // left along y = 3 with -F = (-15, 0, 0) over -2: 30
  EXPECT_DOUBLE_EQ(value_of(measure("work", ""), run), 30.0);
  scene::Measure part = measure("work", "", "left");
  part.from = "up";
  EXPECT_DOUBLE_EQ(value_of(part, run), 30.0);
  part.at = "up";
  EXPECT_DOUBLE_EQ(value_of(part, run), 0.0);
}

TEST(Measures, ForcesAreComparedWithTheFirstRun) {
  const frames::FrameSet run = square_run();
  frames::FrameSet other = run;
  other.force_N[6 * 2 + 4] += 0.3;  // the hand's, second phase: of at most 15
  const auto value = measured(measure("force_difference", ""), other, run);
  ASSERT_TRUE(value && value->number);
  EXPECT_NEAR(*value->number, 0.02, 1e-12);
  EXPECT_EQ(value_of(measure("force_difference", ""), run), 0.0);
}

TEST(Measures, AnUnreachedMomentHasNoNumber) {
  frames::FrameSet run = square_run();
  run.phase.resize(3);
  run.phase_share.resize(3);
  run.phase_share[2] = 0.5;
  EXPECT_EQ(frame_at(run, "left"), std::nullopt);
  EXPECT_EQ(frame_at(run, "up"), std::nullopt);
  EXPECT_EQ(frame_at(run, ""), std::size_t{2});
  const auto value = measured(measure("rms_strain", "green_u", "left"), run, run);
  ASSERT_TRUE(value);
  EXPECT_FALSE(value->number);
  EXPECT_FALSE(measured(measure("kinetic_energy", ""), run, run));
}

TEST(Curves, ForceAndTravelAlongADirectionAndCurvatureAlongTheMaterial) {
  const frames::FrameSet run = square_run();
  scene::Curve curve;
  curve.kind = "force_travel";
  curve.clip = "hand";
  curve.direction = {4.0, 3.0, 0.0};
  const auto line = line_of(curve, run);
  ASSERT_TRUE(line);
  ASSERT_EQ(line->x.size(), 5U);
  EXPECT_DOUBLE_EQ(line->x[2], 0.8 * 2.0 + 0.6 * 3.0);
  EXPECT_DOUBLE_EQ(line->y[2], -0.8 * 15.0);
  curve.kind = "curvature_along";
  curve.strain = "bend_u";
  curve.at = "right";
  curve.direction = {1.0, 0.0, 0.0};
  const auto bend = line_of(curve, run);
  ASSERT_TRUE(bend);
  ASSERT_EQ(bend->x.size(), 1U);
  EXPECT_NEAR(bend->x[0], 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(bend->y[0], 10.0);
}

TEST(ExperimentDocument, EveryKindAnswersAndRunsStandBesideEachOther) {
  frames::FrameSet run = square_run();
  run.time_s = run.kinetic_J = {0.0, 1.0, 2.0, 3.0, 4.0};
  run.velocity_m_s.assign(run.position_m.size(), 0.0);
  scene::Experiment experiment;
  for (const scene::Kind& kind : scene::measure_kinds())
    experiment.measures.push_back(measure(
        std::string(kind.name), kind.name == "rms_curvature" ? "bend_u" : "green_u", "left"));
  for (const scene::Kind& kind : scene::curve_kinds()) {
    scene::Curve curve;
    curve.id = curve.kind = kind.name;
    curve.clip = "hand";
    curve.strain = "bend_u";
    experiment.curves.push_back(curve);
  }
  experiment.pictures.resize(1);
  const frames::FrameSet none;
  const auto document =
      experiment_json(experiment, {{"whole", &run, ""}, {"failed", &none, "no start"}});
  ASSERT_TRUE(document) << document.error().message;
  const nlohmann::json& whole = (*document)["runs"][0];
  for (const auto& [id, value] : whole["measures"].items()) EXPECT_TRUE(value.is_number()) << id;
  EXPECT_EQ(whole["measures"].size(), experiment.measures.size());
  for (const auto& curve : whole["curves"]) EXPECT_GT(curve["x"]["values"].size(), 0U) << curve;
  EXPECT_EQ(whole["pictures"][0]["position_m"][3], nlohmann::json({0.3, 0.06, 0.004123}));
  EXPECT_EQ(whole["triangles"], nlohmann::json({{0, 1, 2}, {1, 3, 2}}));
  const nlohmann::json& failed = (*document)["runs"][1];
  EXPECT_EQ(failed["completed"], false);
  EXPECT_TRUE(failed["measures"]["rms_curvature"].is_null());
  EXPECT_TRUE(failed["pictures"][0]["position_m"].empty());
  experiment.measures[0].strain = "bend_v";
  EXPECT_EQ(experiment_json(experiment, {{"whole", &run, ""}}).error().message,
            "experiment.measures 'mean_strain': no term of the model has the strain 'bend_v'");
}

}  // namespace
}  // namespace tenter::experiment
