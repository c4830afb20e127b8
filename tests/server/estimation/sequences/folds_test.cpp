// SPDX-License-Identifier: GPL-3.0-or-later
// Folds that were made with a known wavelength and direction, and what is said of two sheets.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/model/presets.h"
#include "server/estimation/sequences/folds/fold_comparison.h"

namespace tenter::estimation {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSide_m = 0.1;
constexpr double kSigma_m = 7.5e-5;

struct Wrinkles {
  double height_m = 1e-3;
  double wavelength_m = 0.02;
  double direction_rad = 0.4;
  double phase_rad = 0.0;
  double bend_1_m = 0.0;  ///< the sheet lies on a cylinder of this curvature about y
};

/// Irregular places, one in each cell of a lattice, with or without noise.
SheetPoints sheet(const Wrinkles& wrinkles, double sigma_m, int cells = 50) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> within(0.0, 1.0);
  std::normal_distribution<double> normal;
  SheetPoints points{Eigen::Matrix2Xd(2, cells * cells), Eigen::Matrix3Xd(3, cells * cells)};
  for (int k = 0; k < cells * cells; ++k) {
    const double u = kSide_m * (k % cells + within(random)) / cells;
    const double v = kSide_m * (k / cells + within(random)) / cells;
    const double along =
        u * std::cos(wrinkles.direction_rad) + v * std::sin(wrinkles.direction_rad);
    const double w = wrinkles.height_m *
                     std::cos(2.0 * kPi * along / wrinkles.wavelength_m + wrinkles.phase_rad);
    const double turn = wrinkles.bend_1_m * u;
    const double x = wrinkles.bend_1_m > 0.0 ? std::sin(turn) / wrinkles.bend_1_m : u;
    const double z = wrinkles.bend_1_m > 0.0 ? (std::cos(turn) - 1.0) / wrinkles.bend_1_m : 0.0;
    points.material_m.col(k) << u, v;
    points.position_m.col(k) << x + w * std::sin(turn), v, z + w * std::cos(turn);
    for (int c = 0; c < 3; ++c) points.position_m(c, k) += sigma_m * normal(random);
  }
  return points;
}

TEST(FoldMeasure, FindsWhatWasMade) {
  for (const double wavelength_m : {0.012, 0.018, 0.025})
    for (const double direction_rad : {0.0, 0.4, 1.5, 2.6}) {
      const Wrinkles made{.wavelength_m = wavelength_m, .direction_rad = direction_rad};
      const FoldMeasure found = measure_folds(sheet(made, kSigma_m), kSigma_m).value();
      ASSERT_TRUE(found.is_folded);
      EXPECT_NEAR(found.wavelength_m, wavelength_m, 0.04 * wavelength_m) << direction_rad;
      EXPECT_NEAR(std::sin(found.direction_rad - direction_rad), 0.0, 0.03) << wavelength_m;
      EXPECT_NEAR(found.height_m, 1e-3, 5e-5) << wavelength_m;
      EXPECT_GT(found.alignment, 0.9);
      EXPECT_NEAR(found.steepness, 2.0 * kPi * 1e-3 / wavelength_m, 0.1 * found.steepness);
    }
}

TEST(FoldMeasure, FindsThreeFoldsToASideNearly) {
  const FoldMeasure found =
      measure_folds(sheet({.wavelength_m = 0.033}, kSigma_m), kSigma_m).value();
  ASSERT_TRUE(found.is_folded);
  EXPECT_NEAR(found.wavelength_m, 0.033, 0.1 * 0.033);
  EXPECT_NEAR(found.height_m, 1e-3, 1.2e-4);
}

TEST(FoldMeasure, FindsFoldsOfABentSheetUnderNoise) {
  const Wrinkles made{
      .height_m = 2e-4, .wavelength_m = 0.015, .direction_rad = 1.2, .bend_1_m = 12.0};
  const FoldMeasure found = measure_folds(sheet(made, kSigma_m), kSigma_m).value();
  ASSERT_TRUE(found.is_folded);
  EXPECT_NEAR(found.wavelength_m, 0.015, 6e-4);
  EXPECT_NEAR(found.direction_rad, 1.2, 0.03);
  EXPECT_NEAR(found.height_m, 2e-4, 2e-5);
}

TEST(FoldMeasure, SeesNoneInNoiseAndInABentSheet) {
  for (const double bend_1_m : {0.0, 12.0}) {
    const Wrinkles none{.height_m = 0.0, .bend_1_m = bend_1_m};
    EXPECT_FALSE(measure_folds(sheet(none, kSigma_m), kSigma_m)->is_folded) << bend_1_m;
  }
}

TEST(FoldMeasure, HasNoAlignmentWhereFoldsCross) {
  const SheetPoints one = sheet({.direction_rad = 0.0}, 0.0);
  const SheetPoints other = sheet({.direction_rad = 0.5 * kPi}, 0.0);
  SheetPoints both = one;
  both.position_m.row(2) += other.position_m.row(2);
  const FoldMeasure found = measure_folds(both, 0.0).value();
  ASSERT_TRUE(found.is_folded);
  EXPECT_LT(found.alignment, 0.2);
  EXPECT_NEAR(found.wavelength_m, 0.02, 1e-3);
}

TEST(FoldMeasure, SaysWhatDoesNotFit) {
  SheetPoints points = sheet({}, 0.0);
  EXPECT_EQ(measure_folds(points, -1.0).error().message,
            "folds: a standard deviation below zero or no number");
  points.position_m.rightCols(2480).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(measure_folds(points, 0.0).error().message, "folds: 20 points, at least 40 are needed");
  points = sheet({}, 0.0);
  points.material_m.row(1).setZero();
  EXPECT_EQ(measure_folds(points, 0.0).error().message,
            "folds: the points lie on lines, not over a sheet");
}

TEST(FoldComparison, SaysWhereDistancesMeanSomething) {
  const Wrinkles made;
  const auto meaning = [&](const Wrinkles& simulated) {
    return compare_folds(sheet(made, kSigma_m), sheet(simulated, 0.0), kSigma_m)->positions;
  };
  EXPECT_EQ(meaning(made), PositionMeaning::folds_in_place);
  EXPECT_EQ(meaning({.phase_rad = kPi}), PositionMeaning::folds_elsewhere);
  EXPECT_EQ(meaning({.wavelength_m = 0.03}), PositionMeaning::other_folds);
  EXPECT_EQ(meaning({.direction_rad = 1.2}), PositionMeaning::other_folds);
  EXPECT_EQ(meaning({.height_m = 0.0}), PositionMeaning::only_one_is_folded);
  const Wrinkles flat{.height_m = 0.0};
  EXPECT_EQ(compare_folds(sheet(flat, kSigma_m), sheet(flat, 0.0), kSigma_m)->positions,
            PositionMeaning::no_folds);
  // lower than the noise they do not part points, wherever they are
  const Wrinkles low{.height_m = 0.8 * kSigma_m},
      turned{.height_m = 0.8 * kSigma_m, .phase_rad = kPi};
  EXPECT_TRUE(measure_folds(sheet(low, kSigma_m), kSigma_m)->is_folded);
  EXPECT_EQ(compare_folds(sheet(low, kSigma_m), sheet(turned, 0.0), kSigma_m)->positions,
            PositionMeaning::no_folds);
  EXPECT_TRUE(is_meaningful(PositionMeaning::folds_in_place));
  EXPECT_FALSE(is_meaningful(PositionMeaning::folds_elsewhere));
}

/// A square of which all nodes were seen.
Sequence seen_square(const Wrinkles& wrinkles, mechanics::State& state) {
  Sequence sequence;
  sequence.name = "wrinkled";
  const mechanics::Grid grid{25, 25, kSide_m, kSide_m};
  sequence.cloth = cloth_of_grid(grid, mechanics::Diagonals::both).value();
  const auto& mesh = sequence.cloth.mesh;
  state.x.resize(3 * mesh.node_count());
  sequence.frames.emplace_back().points_m.resize(3, mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const Eigen::Vector2d at = mesh.material_m.col(n);
    const double w = wrinkles.height_m * std::cos(2.0 * kPi * at.x() / wrinkles.wavelength_m);
    state.x.segment<3>(3 * n) << at, w;
    sequence.points.push_back({at, kSigma_m});
    sequence.frames[0].points_m.col(n) << at, w;
  }
  return sequence;
}

TEST(FoldComparison, ReadsFramesOfASequence) {
  mechanics::State state;
  Sequence sequence = seen_square({.wavelength_m = 0.025}, state);
  sequence.frames[0].points_m.col(7).setConstant(std::numeric_limits<double>::quiet_NaN());
  const FoldComparison same = compare_folds(sequence, 0, state).value();
  EXPECT_EQ(same.positions, PositionMeaning::folds_in_place);
  EXPECT_NEAR(same.likeness, 1.0, 1e-9);
  EXPECT_NEAR(same.measured.wavelength_m, 0.025, 1.3e-3);
  EXPECT_FALSE(compare_folds(sequence, 1, state));
}

TEST(FoldComparison, BendingTakesTheEnergyWhereNothingIsStretched) {
  mechanics::State state;
  const Sequence sequence = seen_square({.height_m = 0.0}, state);
  const model::Model model = model::preset("cloth_stvk").value();
  const auto bound = mechanics::MeshModel::make(model, sequence.cloth).value();
  const Eigen::VectorXd parameters = mechanics::term_parameters(model);
  const auto& mesh = sequence.cloth.mesh;
  const auto share_at = [&](double stretch, double curvature_1_m) {
    for (int n = 0; n < mesh.node_count(); ++n) {
      const double turn = curvature_1_m * mesh.material_m(0, n);
      state.x.segment<3>(3 * n) << stretch * std::sin(turn) / curvature_1_m, mesh.material_m(1, n),
          stretch * std::cos(turn) / curvature_1_m;
    }
    return bending_share(model, bound, parameters, state.x).value();
  };
  EXPECT_GT(share_at(1.0, 20.0), 0.9);
  EXPECT_LT(share_at(1.02, 2.0), 0.01);
}

}  // namespace
}  // namespace tenter::estimation
