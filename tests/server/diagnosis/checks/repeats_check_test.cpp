// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/repeats_check.h"

#include <gtest/gtest.h>

#include "server/diagnosis/prepare.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::diagnosis {
namespace {

/// A linear cloth in loops with white noise; the stresses of one run (none for -1) are multiplied.
RepeatsCheck check(int runs, unsigned seed, int odd_run, double factor, Diagnosis& d) {
  estimation::DataSet set = *testing::data_of({testing::loop_capture({.runs = runs})}, 0.3);
  const model::Model truth = testing::preset_with("stvk_orthotropic", {600.0, 800.0, 150.0, 100.0});
  testing::measure_with(truth, 0.3, seed, set);
  estimation::Curves& curves = set.curves.front();
  if (odd_run >= 0) {
    const estimation::CurveRun& run = curves.runs[static_cast<std::size_t>(odd_run)];
    for (auto& channel : curves.channels)
      for (int f = run.first; f < run.last; ++f)
        channel.measured[static_cast<std::size_t>(f)] *= factor;
  }
  const auto data = std::make_shared<const estimation::DataSet>(set);
  const auto at = make_reference(truth, data, {});
  EXPECT_TRUE(at);
  const auto [noise, weighed] = reweigh(data, data->rows(), at->fit.residuals);
  const auto again = make_reference(at->model, weighed, {});
  EXPECT_TRUE(again);
  RepeatsCheck result = check_repeats(*again, weighed, noise, examine(weighed->curves), seed);
  report_repeats(d, result);
  return result;
}

TEST(RepeatsCheck, RaisesNothingBetweenEqualRepeats) {
  for (const int runs : {4, 5, 7}) {
    int alarms = 0;
    for (unsigned seed = 1; seed <= 8; ++seed) {
      Diagnosis d;
      const RepeatsCheck found = check(runs, seed, -1, 1.0, d);
      EXPECT_EQ(found.pairs, runs == 4 ? 3 : 4);
      EXPECT_GT(found.ratio, 0.0);
      ASSERT_EQ(d.checklist.size(), 1U);
      EXPECT_EQ(d.checklist.front().level, found.raised() ? "WARNING" : "OK");
      alarms += found.raised() ? 1 : 0;
    }
    EXPECT_LE(alarms, 1) << runs << " runs";
  }
}

TEST(RepeatsCheck, RaisesARepeatThatDiffers) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Diagnosis d;
    const RepeatsCheck found = check(5, seed, 2, 1.1, d);
    EXPECT_TRUE(found.raised()) << "ratio " << found.ratio << " of " << found.allowed;
    EXPECT_FALSE(found.effect.empty());
    ASSERT_EQ(d.checklist.size(), 1U);
    EXPECT_EQ(d.checklist.front().level, "WARNING");
    EXPECT_NE(d.checklist.front().what.find(found.effect), std::string::npos);
  }
}

TEST(RepeatsCheck, KeepsTheFirstRunApart) {
  Diagnosis d;
  EXPECT_FALSE(check(5, 1, 0, 1.1, d).raised());
}

TEST(RepeatsCheck, SaysThatTwoAreTooFew) {
  for (const int runs : {2, 3}) {
    Diagnosis d;
    EXPECT_EQ(check(runs, 1, -1, 1.0, d).pairs, 0);
    ASSERT_EQ(d.checklist.size(), 1U);
    EXPECT_EQ(d.checklist.front().level, "WARNING");
  }
}

TEST(RepeatsCheck, HasNothingToSayOfOneRun) {
  Diagnosis d;
  EXPECT_EQ(check(1, 1, -1, 1.0, d).pairs, 0);
  EXPECT_TRUE(d.checklist.empty());
}

}  // namespace
}  // namespace tenter::diagnosis
