// SPDX-License-Identifier: GPL-3.0-or-later
// A table of weights and lengths, from CSV to the job's documents, as a user and the worker have
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/report/html_report.h"
#include "common/report/residual_file.h"
#include "common/report/text_report.h"
#include "tests/server/jobs/friction_test/friction_job_fixture.h"
#include "tests/twin/friction/hanging_cloth.h"

namespace tenter::jobs {
namespace {

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

class HangingWeightsJob : public FrictionJob {
 protected:
  using Readings = std::vector<twin::HangingReading>;

  void import_weights(const twin::FrictionSample& sample) {
    import_weights(twin::hang(sample, {}));
  }
  void import_weights(const Readings& readings) {
    const twin::HangingPlan plan;
    std::ostringstream csv;
    csv.precision(12);
    csv << "run,weight_N,length_mm\n";
    for (const twin::HangingReading& reading : readings)
      csv << reading.run + 1 << ',' << reading.weight_N + plan.dead_weight_N << ','
          << 1e3 * reading.length_m << '\n';
    import("weights", csv.str(), kDescription);
  }
};

TEST_F(HangingWeightsJob, GivesTheNumbersOfTheTable) {
  const twin::FrictionSample& sample = twin::stretch_samples().back();
  import_weights(sample);
  const auto result = run({{"protocol", "hanging-weights"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& test = (*result)["friction_test"]["parts"][0];
  EXPECT_EQ(test["direction"], "warp");
  EXPECT_NEAR(test["noise"].get<double>(), 1e-4, 1e-9);
  EXPECT_EQ(test["noise_unit"], "m");
  EXPECT_EQ((*result)["baseline_model"], (*result)["model"]);
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
  for (const char* part :
       {"friction.tau", "id=\"friction\"", "Length against weight", "5 of 5 numbers are told"})
    EXPECT_NE(page->find(part), std::string::npos) << part;
  const auto words = report::render_text(text_);
  ASSERT_TRUE(words);
  EXPECT_NE(words->find("Warp (hanging-weights)"), std::string::npos);
  // readings lie about the model as the noise has it
  const auto tables = report::read_residuals((folder_ / "staging" / "residuals.h5").string(),
                                             {.channel = "hanging_stretch"});
  ASSERT_TRUE(tables);
  ASSERT_EQ(tables->size(), 1U);
  double squares = 0.0;
  for (std::size_t i = 0; i < tables->front().size(); ++i)
    squares += std::pow((tables->front().measured[i] - tables->front().predicted_extended[i]) /
                            tables->front().sigma[i],
                        2);
  const double rms = std::sqrt(squares / static_cast<double>(tables->front().size()));
  EXPECT_GT(rms, 0.7);
  EXPECT_LT(rms, 1.3);
}

TEST_F(HangingWeightsJob, PrintsNoNumberThatTheDataDoNotTell) {
  twin::FrictionSample sample = twin::stretch_samples().front();
  sample.tau = 1e-4;
  import_weights(sample);
  const auto result = run({{"protocol", "hanging-weights"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& tau = (*result)["friction_test"]["parts"][0]["numbers"][4];
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

// Readings that lack something: what they do not tell is said, with the reason, in the document, on
// the page and in the text, and its value is nowhere.
TEST_F(HangingWeightsJob, SaysWhatReadingsLack) {
  const twin::FrictionSample& sample = twin::stretch_samples().back();
  // the last way up of cycles to 9 N; and one step up and down, six times
  const Readings cycles = twin::hang(sample, {.largest_N = 9, .repeats = 1});
  const Readings rising(cycles.end() - 19, cycles.end() - 9);
  const Readings one_step = twin::hang(sample, {.largest_N = 1, .repeats = 6});
  struct Case {
    Readings readings;
    const char* reason;
    const char* number;
  };
  for (const Case& c : {Case{rising, "no weight was taken off again", "b"},
                        Case{one_step, "only 2 different weights were hung", "b"}}) {
    captures_.clear();
    import_weights(c.readings);
    const auto result = run({{"protocol", "hanging-weights"}});
    ASSERT_TRUE(result) << result.error().message;
    int untold = 0;
    bool has_number = false;
    const auto page = report::render_html(text_);
    const auto words = report::render_text(text_, {.width = 400});
    ASSERT_TRUE(page && words);
    for (const json& number : (*result)["friction_test"]["parts"][0]["numbers"]) {
      if (number["told"].get<bool>()) continue;
      ++untold;
      has_number = has_number || number["name"] == c.number;
      EXPECT_TRUE(number["value"].is_null());
      const std::string why = number["words"].get<std::string>();
      EXPECT_NE(why.find(c.reason), std::string::npos) << why;
      EXPECT_NE(page->find(why), std::string::npos);
      EXPECT_NE(words->find(why), std::string::npos);
      const std::string name = "." + number["name"].get<std::string>();
      for (const json& parameter : (*result)["parameters"]) {
        if (!parameter["name"].get<std::string>().ends_with(name)) continue;
        EXPECT_TRUE(parameter["value"].is_null() && parameter["std_error"].is_null());
      }
    }
    EXPECT_GE(untold, 2) << c.reason;
    EXPECT_TRUE(has_number) << (*result)["friction_test"].dump(1);
  }
}

TEST_F(HangingWeightsJob, RefusesWhatIsNoSuchTest) {
  import_weights(twin::stretch_samples().back());
  EXPECT_FALSE(run({{"protocol", "swinging-weights"}}));
  EXPECT_FALSE(run({{"protocol", "hanging-weights"}, {"seed", 3}}));
  EXPECT_FALSE(run({{"protocol", "hanging-weights"}}, "diagnose"));
}

}  // namespace
}  // namespace tenter::jobs
