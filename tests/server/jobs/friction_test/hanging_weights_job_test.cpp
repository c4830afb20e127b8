// SPDX-License-Identifier: GPL-3.0-or-later
// A table of weights and lengths, from CSV to the job's documents, as a user and the worker have
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"
#include "common/model/presets.h"
#include "common/report/html_report.h"
#include "common/report/text_report.h"
#include "server/jobs/results/run_job.h"
#include "tests/twin/friction/hanging_cloth.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kDescription = R"({
  "schema": "tenter.describe", "version": 1, "kind": "homogeneous_strain",
  "title": "Hanging weights, warp",
  "columns": {
    "run": {"is": "run"},
    "weight_N": {"channel": "weight", "quantity": "force", "unit": "N"},
    "length_mm": {"channel": "length", "quantity": "length", "unit": "mm", "sigma": 0.1}
  },
  "specimen": {"name": "square", "material": "cloth", "width": {"value": 100, "unit": "mm"},
               "axis_angle": {"value": 90, "unit": "degree"}},
  "protocol": {"name": "hanging weights", "history": "continues",
               "phases": [{"name": "weights", "kind": "cycle"}]},
  "provenance": {"source": "twin", "synthetic": true},
  "kinematics": {"x": {"role": "prescribed", "channel": "length",
                       "reference_length": {"value": 100, "unit": "mm"}},
                 "y": {"role": "free"}, "xy": {"role": "fixed", "value": 0}},
  "stresses": {"x": "weight"}
})";

class HangingWeightsJob : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-weights-job-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  void import(const twin::FrictionSample& sample) {
    twin::HangingPlan plan;
    std::ofstream csv(folder_ / "weights.csv");
    csv.precision(12);
    csv << "run,weight_N,length_mm\n";
    for (const twin::HangingReading& reading : twin::hang(sample, plan))
      csv << reading.run + 1 << ',' << reading.weight_N + plan.dead_weight_N << ','
          << 1e3 * reading.length_m << '\n';
    csv.close();
    std::ofstream(folder_ / "weights.json") << kDescription;
    const auto capture = capture::import_csv((folder_ / "weights.csv").string(),
                                             (folder_ / "weights.json").string());
    ASSERT_TRUE(capture) << capture.error().message;
    ASSERT_TRUE(capture::write_capture(*capture, (folder_ / "weights.h5").string()));
  }

  Expected<json> run(const json& options, const char* kind = "fit") {
    json spec;
    spec["kind"] = kind;
    spec["captures"] = {std::string(64, 'a')};
    spec["model"] = json::parse(model::preset_json("stvk_diagonal").value());
    spec["options"] = options;
    JobInput input;
    input.spec_json = spec.dump();
    input.captures = {{std::string(64, 'a'), folder_ / "weights.h5"}};
    input.staging = folder_ / "staging";
    fs::remove_all(input.staging);
    fs::create_directories(input.staging);
    const auto done = run_job(input, [](const JobProgress&) {}, {});
    if (!done) return tl::unexpected(done.error());
    EXPECT_TRUE(fs::exists(input.staging / "residuals.h5"));
    std::ostringstream text;
    text << std::ifstream(input.staging / "result.json").rdbuf();
    text_ = text.str();
    return json::parse(text_);
  }

  fs::path folder_;
  std::string text_;
};

TEST_F(HangingWeightsJob, GivesTheNumbersOfTheTable) {
  const twin::FrictionSample& sample = twin::stretch_samples().back();
  import(sample);
  const auto result = run({{"protocol", "hanging-weights"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& test = (*result)["friction_test"];
  EXPECT_EQ(test["direction"], "warp");
  EXPECT_NEAR(test["noise_m"].get<double>(), 1e-4, 1e-9);
  const double truth[] = {sample.k1, sample.k2, sample.a, sample.b, sample.tau};
  ASSERT_EQ(test["numbers"].size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    const json& number = test["numbers"][k];
    ASSERT_TRUE(number["told"].get<bool>()) << number.dump();
    const double width = number["interval"][1].get<double>() - number["interval"][0].get<double>();
    EXPECT_LT(std::abs(number["value"].get<double>() - truth[k]), width) << number.dump();
  }
  EXPECT_EQ(test["stages"].size(), 4U);
  EXPECT_LT((*result)["error_after"].get<double>(), 0.05);
  const auto page = report::render_html(text_);
  ASSERT_TRUE(page) << page.error().message;
  EXPECT_NE(page->find("friction.tau"), std::string::npos);
  EXPECT_TRUE(report::render_text(text_));
}

TEST_F(HangingWeightsJob, PrintsNoNumberThatTheDataDoNotTell) {
  twin::FrictionSample sample = twin::stretch_samples().front();
  sample.tau = 1e-4;
  import(sample);
  const auto result = run({{"protocol", "hanging-weights"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& tau = (*result)["friction_test"]["numbers"][4];
  EXPECT_FALSE(tau["told"].get<bool>());
  EXPECT_TRUE(tau["value"].is_null());
  bool is_withheld = false;
  for (const json& parameter : (*result)["parameters"])
    if (parameter["name"] == "friction.tau") is_withheld = parameter["value"].is_null();
  EXPECT_TRUE(is_withheld);
  bool is_said = false;
  for (const json& check : (*result)["checklist"])
    is_said = is_said || (check["what"] == "tau" &&
                          check["why"].get<std::string>().find("at most") != std::string::npos);
  EXPECT_TRUE(is_said);
}

TEST_F(HangingWeightsJob, RefusesWhatIsNoSuchTest) {
  import(twin::stretch_samples().back());
  EXPECT_FALSE(run({{"protocol", "swinging-weights"}}));
  EXPECT_FALSE(run({{"protocol", "hanging-weights"}, {"seed", 3}}));
  EXPECT_FALSE(run({{"protocol", "hanging-weights"}}, "diagnose"));
}

}  // namespace
}  // namespace tenter::jobs
