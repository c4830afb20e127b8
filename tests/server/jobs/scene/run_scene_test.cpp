// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/frames/frames_file.h"
#include "common/h5/reader.h"
#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/scene/examples.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SceneJob : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-scene-job-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  static json spec(const json& scene, const char* model = "cloth_stvk") {
    return {{"schema", "tenter.job"},
            {"version", 1},
            {"kind", "simulate"},
            {"captures", json::array()},
            {"options", json::object()},
            {"scene", scene},
            {"model", json::parse(model::preset_json(model).value())}};
  }
  static json shipped(const char* name) { return json::parse(scene::example_json(name).value()); }

  Expected<void> run(const json& document, const std::string& name,
                     const std::stop_token& stop = {}) {
    const JobInput input{document.dump(), {}, folder_ / name, {}};
    fs::create_directories(input.staging);
    return run_job(
        input, [this](const JobProgress& p) { progress_.push_back(p); }, stop);
  }

  std::string bytes(const std::string& file) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / file, std::ios::binary).rdbuf();
    return text.str();
  }

  fs::path folder_;
  std::vector<JobProgress> progress_;
};

TEST_F(SceneJob, LeavesFramesThatAgreeWithTheSummary) {
  const json scene = shipped("corner_pull");
  const auto done = run(spec(scene), "a");
  ASSERT_TRUE(done) << done.error().message;
  const json result = json::parse(bytes("a/result.json"));
  EXPECT_EQ(result["schema"], "tenter.simulation");
  EXPECT_EQ(result["completed"], true);
  EXPECT_EQ(result["frames"].size(), 11U);
  EXPECT_EQ(result["clips"], json({"top", "bar"}));
  EXPECT_EQ(result["words"], scene["description"]);
  const model::Model model = model::preset("cloth_stvk").value();
  const model::Parameter& first = model.terms[0].law.parameters[0];
  EXPECT_EQ(result["parameters"][0]["name"], model.terms[0].id + "." + first.name);
  EXPECT_EQ(result["parameters"][0]["value"], first.value);
  EXPECT_EQ(result["parameters"][0]["unit"], first.unit);

  const auto file = h5::H5Reader::open((folder_ / "a/frames.h5").string());
  ASSERT_TRUE(file);
  const auto positions = file->table("/entry/positions/position");
  const auto forces = file->table("/entry/reactions/force");
  const auto energies = file->table("/entry/energies/energy");
  const auto clips = file->table("/entry/reactions/position");
  ASSERT_TRUE(positions && forces && energies && clips);
  using Shape = std::vector<std::uint64_t>;
  EXPECT_EQ(positions->shape, (Shape{11, 625, 3}));
  EXPECT_EQ(forces->shape, (Shape{11, 2, 3}));
  EXPECT_EQ(energies->shape, (Shape{11, 6}));
  for (const auto* table : {&*positions, &*forces, &*energies})
    for (const double value : table->values) ASSERT_TRUE(std::isfinite(value));
  for (std::size_t frame = 0; frame < 11; ++frame) {
    const json& row = result["frames"][frame];
    for (std::size_t c = 0; c < 2; ++c)
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(row["reactions"][c == 0 ? "top" : "bar"]["force_N"][i],
                  forces->values[(frame * 2 + c) * 3 + i]);
    EXPECT_EQ(row["energies_J"]["weft"], energies->values[frame * 6]);
  }
  // the bar's clip is in the middle of its nodes, the lower row, as it hangs level
  const std::vector<double>& x = positions->values;
  const double middle = 0.5 * (x[2] + x[3 * 24 + 2]);
  EXPECT_NEAR(clips->values[3 + 2], middle, 1e-9);
  ASSERT_LT(middle, 0.0);

  const auto strain = file->table("/entry/strains/02_warp_triangle/strain");
  ASSERT_TRUE(strain);
  EXPECT_EQ(strain->shape, (Shape{11, 1152}));
  double largest = 0.0;
  for (const double value : strain->values) largest = std::max(largest, value);
  EXPECT_GT(largest, 0.01);  // 1 N on 0.1 m of 100 N/m: about 10 %
  EXPECT_LT(largest, 1.0);
  EXPECT_EQ(json::parse(*file->text("/entry/scene")), scene);
  EXPECT_EQ(json::parse(*file->text("/entry/model"))["name"], "cloth_stvk");
  EXPECT_TRUE(frames::xdmf_of((folder_ / "a/frames.h5").string()));

  ASSERT_FALSE(progress_.empty());
  EXPECT_EQ(progress_.back().stage, "write");
  for (std::size_t i = 1; i < progress_.size(); ++i)
    EXPECT_GE(progress_[i].fraction, progress_[i - 1].fraction);
  bool named = false;
  for (const JobProgress& p : progress_) named = named || p.detail == "sideways, frame 6 of 10";
  EXPECT_TRUE(named);
}

/// Cotton that is stretched and let go: friction keeps work, pace does not matter.
TEST_F(SceneJob, AnExperimentIsRunWithAllItsVariants) {
  json scene = shipped("stretch_loops_cotton");
  scene["mesh"]["nodes_u"] = scene["mesh"]["nodes_v"] = 3;
  scene["protocol"] = {{{"name", "there"},
                        {"frames", 12},
                        {"duration_s", 6},
                        {"motions", {{{"clip", "top"}, {"move_m", {0, 0.003, 0}}}}}},
                       {{"name", "back"},
                        {"frames", 12},
                        {"duration_s", 6},
                        {"motions", {{{"clip", "top"}, {"move_m", {0, -0.003, 0}}}}}}};
  json& experiment = scene["experiment"];
  experiment["measures"] = {{{"id", "lost"}, {"kind", "work"}, {"clip", "top"}, {"from", "start"}},
                            {{"id", "taken"}, {"kind", "work"}, {"clip", "top"}, {"at", "there"}},
                            {{"id", "rate"}, {"kind", "force_difference"}, {"clip", "top"}}};
  experiment["pictures"] = {
      {{"title", "stretched"}, {"at", "there"}, {"eye", {0, 0, 1}}, {"up", {0, 1, 0}}}};
  const auto done = run(spec(scene, "cotton"), "a");
  ASSERT_TRUE(done) << done.error().message;
  const json found = json::parse(bytes("a/result.json"))["experiment"];
  ASSERT_EQ(found["runs"].size(), 4U);
  const auto number = [&](std::size_t run, const char* measure) {
    return found["runs"][run]["measures"][measure].get<double>();
  };
  const double taken = number(0, "taken");
  ASSERT_GT(taken, 1e-4);
  EXPECT_GT(number(0, "lost"), 0.3 * taken);
  EXPECT_LT(std::abs(number(3, "lost")), 1e-3 * number(3, "taken"));
  EXPECT_LT(std::abs(number(2, "lost") / number(0, "lost") - 1.0), 1e-3);
  EXPECT_EQ(number(0, "rate"), 0.0);
  EXPECT_LT(number(2, "rate"), 2e-3);
  EXPECT_GT(number(3, "rate"), 0.1);
  for (const json& one : found["runs"]) {
    EXPECT_EQ(one["completed"], true);
    EXPECT_EQ(one["curves"][0]["y"]["values"].size(), 25U);
    EXPECT_EQ(one["pictures"][0]["position_m"].size(), 9U);
    EXPECT_EQ(one["triangles"].size(), 8U);
  }
  for (std::size_t i = 1; i < progress_.size(); ++i)
    EXPECT_GE(progress_[i].fraction, progress_[i - 1].fraction);
  bool named = false;
  for (const JobProgress& p : progress_)
    named = named || p.detail == "2 mm/s: back, frame 24 of 24";
  EXPECT_TRUE(named);

  experiment["measures"][0] = {{"id", "x"}, {"kind", "rms_strain"}, {"strain", "bend_q"}};
  const auto refused = run(spec(scene, "cotton"), "b");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "scene: experiment.measures 'x': no term of the model has the strain 'bend_q'");
}

TEST_F(SceneJob, TheSameJobTwiceLeavesTheSameBytes) {
  for (const char* name : {"a", "b"}) ASSERT_TRUE(run(spec(shipped("hanging_square")), name));
  for (const char* file : {"result.json", "frames.h5"}) {
    const std::string one = bytes(std::string("a/") + file);
    ASSERT_GT(one.size(), 1000U);
    EXPECT_EQ(one == bytes(std::string("b/") + file), true) << file;
  }
}

TEST_F(SceneJob, ABodyLeavesItsCells) {
  const json scene = {
      {"schema", "tenter.scene"},
      {"version", 1},
      {"name", "block"},
      {"density_kg_m3", 1000},
      {"mesh", {{"kind", "box"}, {"cells", {3, 2, 2}}, {"size_m", {0.03, 0.02, 0.02}}}},
      {"clips", json::array({{{"id", "wall"}, {"nodes", "left"}}})}};
  const auto done = run(spec(scene, "solid_neo_hookean"), "a");
  ASSERT_TRUE(done) << done.error().message;
  const auto file = h5::H5Reader::open((folder_ / "a/frames.h5").string());
  ASSERT_TRUE(file);
  EXPECT_EQ(*file->shape("/entry/mesh/hexahedron"), (std::vector<std::uint64_t>{12, 8}));
  double volume = 0.0;
  const auto share = file->doubles("/entry/strains/01_shape_hexahedron/share");
  ASSERT_TRUE(share) << share.error().message;
  for (const double value : *share) volume += value;
  EXPECT_NEAR(volume, 0.03 * 0.02 * 0.02, 1e-15);
}

TEST_F(SceneJob, AnEarlyEndKeepsWhatWasReached) {
  json scene = shipped("hanging_square");
  scene["mesh"].update({{"nodes_u", 9}, {"nodes_v", 9}, {"length_u_m", 0.1}, {"length_v_m", 0.1}});
  scene["gravity_m_s2"] = {0, 0, 0};
  scene["clips"] =
      json::array({{{"id", "left"}, {"nodes", "left"}}, {{"id", "right"}, {"nodes", "right"}}});
  scene["solver"] = {{"max_iterations", 4}, {"most_halvings", 1}};
  scene["protocol"] = json::array(
      {{{"name", "closer"},
        {"frames", 2},
        {"motions", json::array({{{"clip", "right"}, {"move_m", {1e-4, 0, 0}}}})}},
       {{"name", "tear"},
        {"frames", 3},
        {"motions",
         json::array(
             {{{"clip", "right"}, {"move_m", {-0.06, 0.04, 0}}, {"turn_rad", {2, 0, 1}}}})}}});
  ASSERT_TRUE(run(spec(scene), "a"));
  const json result = json::parse(bytes("a/result.json"));
  EXPECT_EQ(result["completed"], false);
  EXPECT_EQ(result["frames_asked"], 6);
  ASSERT_EQ(result["frames"].size(), 3U);
  EXPECT_NE(result["reason"].get<std::string>().find("phase 'tear'"), std::string::npos);
  const auto file = h5::H5Reader::open((folder_ / "a/frames.h5").string());
  ASSERT_TRUE(file);
  EXPECT_EQ(file->shape("/entry/positions/position")->front(), 3U);
}

TEST_F(SceneJob, WithoutAnyFrameItFailsAndLeavesNothing) {
  json scene = shipped("hanging_square");
  scene["clips"] = json::array();
  scene["protocol"] = json::array();
  const auto loose = run(spec(scene), "a");
  ASSERT_FALSE(loose);
  EXPECT_EQ(loose.error().kind, ErrorKind::job_failed);
  EXPECT_NE(loose.error().message.find("nothing holds it"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_ / "a"));

  scene = shipped("hanging_square");
  scene["clips"][0]["nodes"] = {{"box_m", {{2, 2}, {3, 3}}}};
  const auto empty = run(spec(scene), "b");
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().message, "scene: clips[0].nodes: no node of the mesh is chosen");

  const auto solid = run(spec(shipped("hanging_square"), "solid_stvk"), "c");
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().kind, ErrorKind::bad_input);

  json huge = shipped("hanging_square");
  huge["protocol"][0]["frames"] = 90000;
  const auto large = run(spec(huge), "d");
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("more than the allowed 1.0 GB"), std::string::npos);
}

TEST_F(SceneJob, StopsSoonAfterItIsAskedTo) {
  json scene = shipped("hanging_square");
  scene["protocol"][0]["frames"] = 3000;
  std::stop_source stop;
  const JobInput input{spec(scene).dump(), {}, folder_ / "a", {}};
  fs::create_directories(input.staging);
  int reports = 0;
  const auto stopped = run_job(
      input,
      [&](const JobProgress& p) {
        if (p.detail == "closer, frame 3 of 3005") stop.request_stop();
        ++reports;
      },
      stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::cancelled);
  EXPECT_LT(reports, 20);
  EXPECT_TRUE(fs::is_empty(folder_ / "a"));
}

}  // namespace
}  // namespace tenter::jobs
