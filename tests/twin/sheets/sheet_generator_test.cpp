// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets with hidden effects: as large as asked for, where they should be, and again the same.
#include "tests/twin/sheets/sheet_generator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace tenter::twin {
namespace {

SheetTwins made(const TwinCase& twin_case) {
  auto twins = make_sheets(twin_case);
  EXPECT_TRUE(twins) << (twins ? "" : twins.error().message);
  return twins ? std::move(*twins) : SheetTwins{};
}

TEST(SheetGenerator, MakesTheSameCaptureAgain) {
  const TwinCase twin_case{.suite = "sheet_markers", .seed = 4};
  const SheetTwins a = made(twin_case), b = made(twin_case);
  ASSERT_EQ(a.readings.plans.size(), 4U);
  std::size_t lost = 0;
  for (std::size_t p = 0; p < a.readings.plans.size(); ++p)
    for (std::size_t f = 0; f < a.readings.plans[p].size(); ++f) {
      const auto& one = a.readings.plans[p][f];
      const auto& other = b.readings.plans[p][f];
      EXPECT_EQ(one.forces_N, other.forces_N);
      for (Eigen::Index k = 0; k < one.points_m.cols(); ++k) {
        lost += std::isnan(one.points_m(0, k)) ? 1U : 0U;
        if (!std::isnan(one.points_m(0, k))) {
          EXPECT_EQ(one.points_m.col(k), other.points_m.col(k));
        }
      }
    }
  EXPECT_GT(lost, 0U);
  EXPECT_LT(lost, 100U);
}

/// What was read with the fault, less what was read without: zero but where it acts.
TEST(SheetGenerator, AFaultOfACellActsOnItAlone) {
  const SheetTwins twins = made({.suite = "sheet_markers", .seed = 6});
  const Hidden3 hidden = hidden_places(twins.suite, Random(1));
  SheetFaults faults;
  faults.cell = "right";
  faults.offset_N = 0.5;
  const SheetReadings plain = read(twins.suite, twins.done, hidden, {});
  const SheetReadings shown = read(twins.suite, twins.done, hidden, faults);
  std::set<std::string> touched;
  for (std::size_t p = 0; p < plain.plans.size(); ++p)
    for (std::size_t f = 0; f < plain.plans[p].size(); ++f) {
      EXPECT_EQ(plain.plans[p][f].points_m, shown.plans[p][f].points_m);
      for (std::size_t k = 0; k < twins.suite.plans[p].cells.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        const double more_N = shown.plans[p][f].forces_N[at] - plain.plans[p][f].forces_N[at];
        if (std::abs(more_N) > 1e-12) {
          EXPECT_NEAR(more_N, 0.5, 1e-12);
          touched.insert(twins.suite.plans[p].cells[k]);
        }
      }
    }
  EXPECT_EQ(touched, std::set<std::string>{"right"});
}

TEST(SheetGenerator, BarsPullAgainstEachOther) {
  const SheetTwins twins = made({.suite = "sheet_markers", .seed = 6});
  const SheetReadings plain =
      read(twins.suite, twins.done, hidden_places(twins.suite, Random(1)), {});
  for (const auto& frame : plain.plans[0]) {
    ASSERT_GT(frame.forces_N[0], 0.0);
    EXPECT_NEAR(frame.forces_N[0], frame.forces_N[1], 1e-4 * frame.forces_N[0]);
  }
}

/// What the twin's own spans are wrong by is below the noise, and far below the effects.
TEST(SheetGenerator, ItsOwnSpansAreFineEnough) {
  const SheetTwins twins = made({.suite = "sheet_markers", .seed = 3});
  SheetSuite finer = twins.suite;
  finer.span_m *= 0.6;
  const auto again = perform(finer, twins.stated, {});
  ASSERT_TRUE(again) << again.error().message;
  const Hidden3 hidden = hidden_places(twins.suite, Random(1));
  const SheetReadings coarse = read(twins.suite, twins.done, hidden, {});
  const SheetReadings fine = read(finer, *again, hidden, {});
  double points = 0.0, forces = 0.0, point_count = 0.0, force_count = 0.0;
  for (std::size_t p = 0; p < coarse.plans.size(); ++p)
    for (std::size_t f = 0; f < coarse.plans[p].size(); ++f) {
      const auto &a = coarse.plans[p][f], &b = fine.plans[p][f];
      points += (a.points_m - b.points_m).squaredNorm() / std::pow(twins.noise.points_m, 2);
      forces += (a.forces_N - b.forces_N).squaredNorm() / std::pow(twins.noise.forces_N, 2);
      point_count += static_cast<double>(a.points_m.size());
      force_count += static_cast<double>(a.forces_N.size());
    }
  EXPECT_LT(std::sqrt(points / point_count), 0.5);
  EXPECT_LT(std::sqrt(forces / force_count), 0.5);
}

TEST(SheetGenerator, EffectsAreAsLargeAsAsked) {
  for (const char* effect : {"load_cell_gain", "heterogeneity"}) {
    const SheetTwins twins =
        made({.effects = {effect}, .size = 3.0, .suite = "sheet_markers", .seed = 2});
    ASSERT_EQ(twins.hidden.size(), 1U);
    EXPECT_NEAR(twins.hidden[0].achieved_size, 3.0, 0.15) << effect;
    EXPECT_GT(twins.hidden[0].share_of_force, 1e-3) << effect;
  }
}

TEST(SheetGenerator, RefusesWhatItCannotHide) {
  EXPECT_FALSE(make_sheets({.effects = {"no_such"}, .size = 3.0, .suite = "sheet_field"}));
  EXPECT_FALSE(
      make_sheets({.effects = {"load_cell_drift"}, .size = 3.0, .suite = "sheet_no_time"}));
  EXPECT_FALSE(make_sheets({.suite = "rich"}));
}

}  // namespace
}  // namespace tenter::twin
