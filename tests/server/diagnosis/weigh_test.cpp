// SPDX-License-Identifier: GPL-3.0-or-later
// A drift differs from repeat to repeat, and passes for noise until it is found; a sharp corner
// passes for misread samples.
#include <gtest/gtest.h>

#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

TEST(Diagnose, MeasuresTheNoiseWithoutTheDriftThatItFound) {
  twin::TwinCase hidden;
  hidden.seed = 101;
  hidden.suite = "rich";
  hidden.effects = {"load_cell_drift:x"};
  hidden.size = 10.0;
  Request request = testing::request_of(hidden);
  request.options.effects = {"load_cell_drift", "load_cell_gain", "load_cell_offset"};
  request.options.null_twins = 50;
  const auto d = diagnose(request, {});
  ASSERT_TRUE(d) << d.error().message;
  EXPECT_NE(d->path.front().why.find("weighed anew"), std::string::npos) << d->path.front().why;
  ASSERT_EQ(d->verdicts.size(), 1U);
  EXPECT_EQ(d->verdicts.front().effect, "load_cell_drift");
  EXPECT_EQ(d->verdicts.front().kind, VerdictKind::sensor);
  // the twin's noise is a hundredth of the force; with the drift repeats differ by six times that
  EXPECT_LT(d->noise_floor, 1.5 * d->after.error);
  EXPECT_GT(d->noise_floor, 0.5 * d->after.error);
}

TEST(Diagnose, TakesReadingsBackThatWhatItFoundReaches) {
  twin::TwinCase hidden;
  hidden.seed = 601;
  hidden.suite = "rich";
  hidden.effects = {"first_cycle_softening"};
  hidden.size = 10.0;
  Request request = testing::request_of(hidden);
  request.options.effects = {"first_cycle_softening", "nonlinear_stiffness"};
  request.options.null_twins = 50;
  const auto prepared = prepare(request, {});
  ASSERT_TRUE(prepared);
  ASSERT_GE(prepared->outliers.size(), 10U);  // where the first pull turns
  const auto d = diagnose(request, {});
  ASSERT_TRUE(d) << d.error().message;
  EXPECT_TRUE(d->outliers.empty());
  EXPECT_EQ(d->data->rows().size(), prepared->data->rows().size() + prepared->outliers.size());
  ASSERT_EQ(d->verdicts.front().effect, "first_cycle_softening");
  // without those readings it would come out 4 % too small
  const double truth = twin::make_twin(hidden)->hidden.front().share_of_force;
  EXPECT_NEAR(d->verdicts.front().size, truth, 0.01 * truth);
}

TEST(Diagnose, KeepsWhatItFoundFirstWhereThatIsBetter) {
  twin::TwinCase hidden;
  hidden.seed = 1001;
  hidden.suite = "rich";
  hidden.effects = {"poisson_coupling", "load_cell_drift:x"};
  hidden.size = 3.0;
  Request request = testing::request_of(hidden);
  request.options.effects = {"poisson_coupling", "load_cell_drift", "plastic_set", "viscosity"};
  request.options.null_twins = 50;
  const auto d = diagnose(request, {});
  ASSERT_TRUE(d) << d.error().message;
  EXPECT_NE(d->path.front().why.find("weighed anew"), std::string::npos) << d->path.front().why;
  // weighed anew, plastic set comes first, and viscosity after it
  ASSERT_EQ(d->path.size(), 3U);
  EXPECT_EQ(d->path.back().why, "as found before");
  ASSERT_EQ(d->verdicts.size(), 2U);
  EXPECT_EQ(d->verdicts[0].effect, "load_cell_drift");
  EXPECT_EQ(d->verdicts[1].effect, "poisson_coupling");
}

TEST(WeighWithout, LeavesTheNoiseAloneWhereRepeatsDifferAsMuch) {
  twin::TwinCase plain;
  plain.seed = 7;
  plain.suite = "rich";
  const Prepared prepared = testing::prepared_twin(plain);
  EXPECT_FALSE(weigh_without(prepared.data, prepared.noise, prepared.baseline));
}

}  // namespace
}  // namespace tenter::diagnosis
