// SPDX-License-Identifier: GPL-3.0-or-later
// Load-unload loops, from CSV to the job's documents; and what only looks like them.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/report/text_report.h"
#include "tests/server/jobs/friction_test/friction_job_fixture.h"
#include "tests/twin/friction/friction_sample.h"
#include "tests/twin/random.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

json loops_description(bool has_time) {
  json d = json::parse(R"({
    "kind": "homogeneous_strain", "title": "Loops, weft",
    "columns": {
      "run": {"is": "run"},
      "stretch": {"quantity": "stretch", "unit": "1"},
      "load_N_m": {"channel": "load", "quantity": "membrane_stress", "unit": "N/m"}
    },
    "specimen": {"name": "strip", "material": "cloth"},
    "protocol": {"name": "loops", "history": "virgin_each_run",
                 "phases": [{"name": "loop", "kind": "cycle"}]},
    "provenance": {"source": "twin", "synthetic": true},
    "kinematics": {"x": {"role": "prescribed", "channel": "stretch"}, "y": {"role": "free"}},
    "stresses": {"x": "load"}
  })");
  if (has_time) d["columns"]["t_s"] = {{"is", "time"}, {"unit", "s"}};
  return d;
}

/// The stretch at a share of a run: up to the top, half of the way back, up again, and down.
double stretch_at(double share, double top) {
  const double turns[] = {0.0, 1.0, 0.5, 1.0, 0.0};
  const double x = std::min(3.999999, 4.0 * share);
  const auto i = static_cast<std::size_t>(x);
  const double part = x - static_cast<double>(i);
  return 1.0 + top * ((1.0 - part) * turns[i] + part * turns[i + 1]);
}

/// Loops of Dahl's friction, or of a Maxwell element beside a spring, each run at its own rate.
std::string loops(const twin::FrictionSample* sample, const std::vector<double>& durations_s) {
  twin::Random noise(twin::stream_seed(5, "loops"));
  std::ostringstream csv;
  csv.precision(12);
  csv << "run,t_s,stretch,load_N_m\n";
  constexpr int kFrames = 160;
  for (std::size_t r = 0; r < durations_s.size(); ++r) {
    twin::FrictionState state;
    double viscous = 0.0;
    double before = 1.0;
    const double step_s = durations_s[r] / kFrames;
    for (int i = 0; i <= kFrames; ++i) {
      const double stretch = stretch_at(static_cast<double>(i) / kFrames, 0.1);
      const double strain = 0.5 * (stretch * stretch - 1.0);
      double load = 0.0;
      if (sample != nullptr) {
        state = twin::moved(*sample, state, strain);
        load = twin::stress(*sample, state) * stretch;
      } else {
        // relaxation time 10 s
        const double decay = std::exp(-step_s / 10.0);
        viscous = viscous * decay + 400.0 * (stretch - before) * 10.0 / step_s * (1.0 - decay);
        load = 100.0 * strain + viscous;
      }
      before = stretch;
      csv << r + 1 << ',' << i * step_s << ',' << stretch << ',' << load + 0.02 * noise.normal()
          << '\n';
    }
  }
  return csv.str();
}

using LoopsJob = FrictionJob;

TEST_F(LoopsJob, OfFrictionAtTwoRatesGiveTheNumbers) {
  const twin::FrictionSample& cloth = twin::stretch_samples().back();
  import("loops", loops(&cloth, {4.0, 40.0}), loops_description(true).dump());
  const auto result = run({{"protocol", "loops"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& part = (*result)["friction_test"]["parts"][0];
  EXPECT_EQ(part["direction"], "weft");
  const double truth[] = {cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau};
  for (std::size_t k = 0; k < 5; ++k) {
    const json& number = part["numbers"][k];
    ASSERT_TRUE(number["told"].get<bool>()) << number.dump();
    const double width = number["interval"][1].get<double>() - number["interval"][0].get<double>();
    EXPECT_LT(std::abs(number["value"].get<double>() - truth[k]), width) << number.dump();
    // over strains of a tenth k2 and b count for little
    if (k != 1 && k != 3) {
      EXPECT_LT(width, 0.5 * truth[k]) << number.dump();
    }
  }
  EXPECT_EQ(part["rate"]["answer"], "friction");
  EXPECT_NEAR(part["rate"]["loss_ratio"].get<double>(), 1.0, 0.02);
  EXPECT_NEAR(part["lost_share"].get<double>(), part["lost_share_of_model"].get<double>(), 0.01);
  EXPECT_GT(part["lost_share"].get<double>(), 0.1);
  EXPECT_TRUE(report::render_text(text_));
}

TEST_F(LoopsJob, WithoutTimesAreFittedWithAWarning) {
  json description = loops_description(false);
  description["columns"]["t_s"] = "ignore";
  import("loops", loops(&twin::stretch_samples().back(), {4.0}), description.dump());
  const auto result = run({{"protocol", "loops"}});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ((*result)["friction_test"]["parts"][0]["rate"]["answer"], "cannot tell");
  bool is_warned = false;
  for (const json& check : (*result)["checklist"])
    is_warned =
        is_warned || (check["level"] == "WARNING" && check["what"] == "friction or viscosity");
  EXPECT_TRUE(is_warned);
}

TEST_F(LoopsJob, ThatDependOnTheRateAreRefusedWithTheEvidence) {
  import("loops", loops(nullptr, {4.0, 40.0}), loops_description(true).dump());
  const auto result = run({{"protocol", "loops"}});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::refused);
  for (const char* words : {"refused as friction", "depends on the rate", "At 10 times the rate"})
    EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
}

TEST_F(LoopsJob, SayWhatIsMissing) {
  import("loops", loops(&twin::stretch_samples().back(), {4.0}), loops_description(true).dump());
  EXPECT_NE(refusal({{"protocol", "loops"}, {"direction", "warp"}}).find("no run strains warp"),
            std::string::npos);
  EXPECT_NE(refusal({{"protocol", "loops"}, {"direction", "bias"}}).find("options.direction"),
            std::string::npos);
  EXPECT_NE(refusal({{"protocol", "loops"}, {"samples", 5}}).find("options.samples"),
            std::string::npos);
}

}  // namespace
}  // namespace tenter::jobs
