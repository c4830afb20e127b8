// SPDX-License-Identifier: GPL-3.0-or-later
// Points that jumped away for a frame, among noise, long tails, smooth misfits and hidden points.
#include "server/diagnosis/field/noise/misread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <tuple>

#include "server/diagnosis/screening/normal.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using Place = std::tuple<int, int, int>;  // sequence, frame, point

/// A sheet's rows, with residuals to be filled in.
struct Sheet {
  FieldData data;
  std::vector<estimation::Row> rows;
  Eigen::VectorXd residuals;

  Sheet() {
    const testing::SheetTruth truth{.model = testing::compliant_cloth(),
                                    .protocols = {"stretch_u"}};
    data = testing::data_of(testing::sheets_of(truth, testing::compliant_cloth()));
    const auto at = predict_field(truth.model, data, {}, {});
    if (!at) throw std::runtime_error(at.error().message);
    rows = at->rows;
    residuals.setZero(static_cast<Eigen::Index>(rows.size()));
  }

  const estimation::Sequence& sequence() const { return data.sequences.front(); }
  bool is_point(const estimation::Row& row) const {
    return row.channel < 3 * static_cast<int>(sequence().points.size());
  }
  std::set<Place> found() const {
    std::set<Place> places;
    for (const Misread& m : find_misread(data.sequences, rows, residuals))
      places.insert({m.sequence, m.frame, m.point});
    return places;
  }
  void add_noise(double size, unsigned seed) {
    Normal normal(seed);
    for (double& r : residuals) r += size * normal();
  }
  /// So many sigmas in one coordinate of a point.
  void move(int frame, int point, double sigmas, int coordinate = 0) {
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows[r].frame == frame && rows[r].channel == 3 * point + coordinate)
        residuals[static_cast<Eigen::Index>(r)] += sigmas;
  }
};

TEST(Misread, ArePointsThatJumpedAwayAndNoOthers) {
  for (const double noise : {0.3, 1.0, 4.0}) {
    Sheet sheet;
    sheet.add_noise(noise, 11);
    sheet.move(4, 30, 25.0 * noise);
    sheet.move(9, 12, -40.0 * noise, 1);
    sheet.move(10, 12, -40.0 * noise, 1);
    const std::set<Place> jumped = {{0, 4, 30}, {0, 9, 12}, {0, 10, 12}};
    EXPECT_EQ(sheet.found(), jumped) << noise;
  }
}

TEST(Misread, SayHowFarTheReadingIsOff) {
  Sheet sheet;
  sheet.add_noise(0.01, 3);
  sheet.move(4, 30, 20.0);  // simulated less measured
  const auto misread = find_misread(sheet.data.sequences, sheet.rows, sheet.residuals);
  ASSERT_EQ(misread.size(), 1U);
  const double sigma_m = sheet.sequence().points[30].sigma_m;
  EXPECT_NEAR(misread.front().off_m, -20.0 * sigma_m, 0.1 * sigma_m);
}

TEST(Misread, IsNothingWhereNoiseHasLongTails) {
  Sheet sheet;
  std::mt19937_64 engine(5);
  std::student_t_distribution<double> tails(3.0);
  for (double& r : sheet.residuals) r = tails(engine);
  EXPECT_TRUE(sheet.found().empty());
}

TEST(Misread, IsNothingWhereManyPointsScatterOtherwise) {
  Sheet sheet;
  sheet.add_noise(1.0, 13);
  Normal normal(9);
  for (std::size_t r = 0; r < sheet.rows.size(); ++r)
    if (sheet.is_point(sheet.rows[r]) && sheet.rows[r].channel / 3 % 7 == 0)
      sheet.residuals[static_cast<Eigen::Index>(r)] += 60.0 * normal();
  EXPECT_TRUE(sheet.found().empty());
}

TEST(Misread, IsNothingWhereTheModelMisses) {
  Sheet sheet;
  sheet.add_noise(1.0, 7);
  for (std::size_t r = 0; r < sheet.rows.size(); ++r) {
    const estimation::Row& row = sheet.rows[r];
    if (!sheet.is_point(row)) continue;
    const auto& place = sheet.sequence().points[static_cast<std::size_t>(row.channel / 3)];
    const bool is_left = place.material_m.x() < 0.03;
    // a slip in one frame's step, and a bump over the material
    sheet.residuals[static_cast<Eigen::Index>(r)] +=
        (row.frame >= 8 ? 60.0 : 0.0) + (is_left ? 40.0 * std::sin(row.frame) : 0.0);
  }
  EXPECT_TRUE(sheet.found().empty());
}

TEST(Misread, BesideAHiddenPointAreNotThoseThatItDraws) {
  for (const int coordinate : {0, 1, 2}) {
    Sheet sheet;
    sheet.add_noise(1.0, 11);
    sheet.move(4, 30, 25.0, coordinate);
    const auto at = [&](int point) {
      return sheet.sequence().points[static_cast<std::size_t>(point)].material_m;
    };
    int nearest = 0;
    for (int p = 1; p < static_cast<int>(sheet.sequence().points.size()); ++p)
      if (p != 30 && (at(p) - at(30)).norm() < (at(nearest) - at(30)).norm()) nearest = p;
    for (int c = 0; c < 3; ++c) sheet.move(4, nearest, std::nan(""), c);
    const std::set<Place> jumped = {{0, 4, 30}};
    EXPECT_EQ(sheet.found(), coordinate == 2 ? std::set<Place>() : jumped);
  }
}

TEST(Misread, AreSeenNoMoreAndNotHidden) {
  Sheet sheet;
  set_aside({{0, 4, 30, 1e-3, 20.0}}, sheet.data.sequences);
  const estimation::SequenceFrame& frame = sheet.sequence().frames[4];
  EXPECT_TRUE(frame.points_m.col(30).array().isNaN().all());
  EXPECT_EQ(frame.misread, std::vector<int>{30});
  EXPECT_TRUE(estimation::check(sheet.sequence()));
}

}  // namespace
}  // namespace tenter::diagnosis
