// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/effect_size.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "tests/server/diagnosis/two_channels.h"

namespace tenter::diagnosis {
namespace {

constexpr int kBlocks = 12;
constexpr int kFrames = 15;

/// Least squares of whitened readings by some columns, as a fit's result.
estimation::FitResult linear_fit(const Eigen::MatrixXd& columns, const Eigen::VectorXd& readings) {
  estimation::FitResult fit;
  const Eigen::VectorXd p = columns.colPivHouseholderQr().solve(readings);
  fit.residuals = columns * p - readings;
  fit.jacobian = columns;
  fit.states.assign(static_cast<std::size_t>(columns.cols()), estimation::ParameterState::free);
  return fit;
}

/// Columns over all rows: a constant on the force, and an effect on force (or stretch) beside it.
struct Problem {
  estimation::DataSet set = two_channels(kBlocks, kFrames);
  Eigen::MatrixXd own, all;

  explicit Problem(int channel) {
    const auto rows = set.rows();
    const auto n = static_cast<Eigen::Index>(rows.size());
    own = Eigen::MatrixXd::Zero(n, 1);
    all = Eigen::MatrixXd::Zero(n, 3);
    for (Eigen::Index r = 0; r < n; ++r) {
      const auto& row = rows[static_cast<std::size_t>(r)];
      const double phase = 2.0 * (row.frame % kFrames) / (kFrames - 1.0) - 1.0;
      if (row.channel == 0) own(r, 0) = all(r, 0) = 1.0;
      if (row.channel != channel) continue;
      all(r, 1) = phase;
      all(r, 2) = phase * phase;
    }
  }

  /// An effect of so many sigmas (rms of what the constant cannot take), with this noise.
  SizeInterval measure(double sigmas, const Eigen::VectorXd& noise) const {
    const Eigen::VectorXd effect = all.col(1) + 0.5 * all.col(2);
    return measure_reading(sigmas * unabsorbed(effect) + noise);
  }
  SizeInterval measure_reading(const Eigen::VectorXd& readings) const {
    return effect_size(set, linear_fit(own, readings), linear_fit(all, readings), 5);
  }
  /// rms of one over the rows on which it is not zero
  Eigen::VectorXd unabsorbed(const Eigen::VectorXd& effect) const {
    const Eigen::VectorXd left = effect - own * own.colPivHouseholderQr().solve(effect);
    return left * std::sqrt(kBlocks * kFrames / left.squaredNorm());
  }
};

Eigen::VectorXd none(const Problem& problem) {
  return Eigen::VectorXd::Zero(problem.all.rows());
}

TEST(EffectSize, WithoutNoiseIsTheShareOfTheForce) {
  const Problem problem(0);
  // 4 sigma of 0.5 are 2 of 10
  const SizeInterval size = problem.measure(4.0, none(problem));
  EXPECT_TRUE(size.of_force);
  EXPECT_NEAR(size.size, 0.2, 1e-12);
  EXPECT_NEAR(size.lo, 0.2, 1e-9);
  EXPECT_NEAR(size.hi, 0.2, 1e-9);
}

TEST(EffectSize, IsOfTheStretchWhereTheForceIsLeftAlone) {
  const Problem problem(1);
  // 20 sigma of 0.001 are a fifth of the stretch beyond one
  const SizeInterval size = problem.measure(20.0, none(problem));
  EXPECT_FALSE(size.of_force);
  EXPECT_NEAR(size.size, 0.2, 1e-9);
}

TEST(EffectSize, OfAFitThatAddsNothingIsNothing) {
  const Problem problem(0);
  const Eigen::VectorXd readings = Eigen::VectorXd::LinSpaced(problem.own.rows(), -1.0, 1.0);
  const auto fit = linear_fit(problem.own, readings);
  const SizeInterval size = effect_size(problem.set, fit, fit, 1);
  EXPECT_EQ(size.size, 0.0);
  EXPECT_EQ(size.hi, 0.0);
}

/// Errors of a block have a common part, as real ones do.
Eigen::VectorXd block_noise(const Problem& problem, std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  std::vector<double> common(kBlocks);
  for (double& c : common) c = 0.5 * normal(engine);
  const auto rows = problem.set.rows();
  Eigen::VectorXd noise(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double tilt = 2.0 * (rows[r].frame % kFrames) / (kFrames - 1.0) - 1.0;
    noise[static_cast<Eigen::Index>(r)] =
        std::sqrt(0.75) * normal(engine) + tilt * common[static_cast<std::size_t>(rows[r].block)];
  }
  return noise;
}

TEST(EffectSize, ItsIntervalHoldsTheTruthAsOftenAsItSays) {
  const Problem problem(0);
  for (const double sigmas : {0.5, 1.0, 4.0}) {
    std::mt19937_64 engine(17);
    const double truth = sigmas * 0.05;
    int held = 0;
    double mean = 0.0;
    double width = 0.0;
    constexpr int kSeeds = 200;
    for (int k = 0; k < kSeeds; ++k) {
      const SizeInterval size = problem.measure(sigmas, block_noise(problem, engine));
      held += size.lo <= truth && truth <= size.hi ? 1 : 0;
      mean += size.size / kSeeds;
      width += (size.hi - size.lo) / kSeeds;
    }
    EXPECT_GE(held, 179) << sigmas;
    EXPECT_LE(held, 198) << sigmas;
    EXPECT_NEAR(mean, truth, 0.05 * truth) << sigmas;
    EXPECT_GT(width, 0.01 * truth);
  }
}

TEST(EffectSize, OfAnEffectThatShowsInOneBlockIsKnownNoBetterThanItsNoise) {
  Problem problem(0);
  const auto rows = problem.set.rows();
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows[r].block != 4) problem.all.row(static_cast<Eigen::Index>(r)).tail(2).setZero();
  const Eigen::VectorXd effect = problem.unabsorbed(problem.all.col(1) + 0.5 * problem.all.col(2));
  const double truth =
      problem.measure_reading(effect).size;  // without noise, all that the constant does not take
  std::mt19937_64 engine(23);
  std::normal_distribution<double> normal;
  int held = 0;
  constexpr int kSeeds = 200;
  for (int k = 0; k < kSeeds; ++k) {
    Eigen::VectorXd reading = effect;
    for (double& x : reading) x += normal(engine);
    const SizeInterval size = problem.measure_reading(reading);
    held += size.lo <= truth && truth <= size.hi ? 1 : 0;
  }
  EXPECT_GE(held, 179);
  EXPECT_LE(held, 199);
}

TEST(EffectSize, IsTheSameForTheSameSeed) {
  const Problem problem(0);
  std::mt19937_64 engine(3);
  const Eigen::VectorXd noise = block_noise(problem, engine);
  const SizeInterval once = problem.measure(1.0, noise);
  const SizeInterval again = problem.measure(1.0, noise);
  ASSERT_GT(once.hi, once.lo);
  EXPECT_EQ(once.lo, again.lo);
  EXPECT_EQ(once.hi, again.hi);
}

}  // namespace
}  // namespace tenter::diagnosis
