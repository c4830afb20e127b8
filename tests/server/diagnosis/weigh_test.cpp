// SPDX-License-Identifier: GPL-3.0-or-later
// A drift differs from repeat to repeat, and passes for noise until it is found; a sharp corner
// passes for misread samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

twin::TwinCase hiding(unsigned seed, std::vector<std::string> effects, double size) {
  twin::TwinCase hidden;
  hidden.seed = seed;
  hidden.suite = "rich";
  hidden.effects = std::move(effects);
  hidden.size = size;
  return hidden;
}

Expected<Diagnosis> diagnosed(const twin::TwinCase& hidden, std::vector<std::string> tried) {
  Request request = testing::request_of(hidden);
  request.options.effects = std::move(tried);
  request.options.null_twins = 50;
  return diagnose(request, {});
}

TEST(Diagnose, MeasuresTheNoiseWithoutTheDriftThatItFound) {
  const auto d = diagnosed(hiding(101, {"load_cell_drift:x"}, 10.0),
                           {"load_cell_drift", "load_cell_gain", "load_cell_offset"});
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
  const twin::TwinCase hidden = hiding(601, {"first_cycle_softening"}, 10.0);
  const auto prepared = prepare(testing::request_of(hidden), {});
  ASSERT_TRUE(prepared);
  ASSERT_GE(prepared->outliers.size(), 10U);  // where the first pull turns
  const auto d = diagnosed(hidden, {"first_cycle_softening", "nonlinear_stiffness"});
  ASSERT_TRUE(d) << d.error().message;
  EXPECT_TRUE(d->outliers.empty());
  EXPECT_EQ(d->data->rows().size(), prepared->data->rows().size() + prepared->outliers.size());
  ASSERT_EQ(d->verdicts.front().effect, "first_cycle_softening");
  // without those readings it would come out 4 % too small
  const double truth = twin::make_twin(hidden)->hidden.front().share_of_force;
  EXPECT_NEAR(d->verdicts.front().size, truth, 0.01 * truth);
}

// a curve of force along every direction is both, but for a little at the corner of the limit
TEST(Diagnose, TakesApartWhatTookTwoCausesAtOnce) {
  const auto d = diagnosed(hiding(1504, {"strain_limit:u", "anisotropy"}, 3.0),
                           {"nonlinear_stiffness", "strain_limit", "anisotropy"});
  ASSERT_TRUE(d) << d.error().message;
  std::set<std::string> found;
  for (const Verdict& verdict : d->verdicts) found.insert(verdict.effect);
  EXPECT_EQ(found, (std::set<std::string>{"strain_limit", "anisotropy"}));
  const bool was_one = std::ranges::any_of(d->path, [](const PathStep& step) {
    return step.action == "drop" && step.effect == "nonlinear_stiffness";
  });
  EXPECT_TRUE(was_one);  // else this test asks nothing
}

TEST(Diagnose, KeepsWhatItFoundFirstWhereThatIsBetter) {
  const auto d = diagnosed(hiding(1001, {"poisson_coupling", "load_cell_drift:x"}, 3.0),
                           {"poisson_coupling", "load_cell_drift", "plastic_set", "viscosity"});
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
