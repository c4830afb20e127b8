// SPDX-License-Identifier: GPL-3.0-or-later
// Weights, robust losses and methods of fit() on a straight line, whose answers are known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/model/presets.h"
#include "server/estimation/fit.h"
#include "server/estimation/least_squares/objective.h"

namespace tenter::estimation {
namespace {

/// y = p0 + p1 t over two curves, long and short; rows of the first weigh `first_weight`.
class Line final : public ResidualFunction {
 public:
  Line(int parameters, int long_rows, int short_rows, double first_weight)
      : parameters_(parameters), weights_(long_rows + short_rows) {
    measured.setZero(long_rows + short_rows);
    for (int k = 0; k < long_rows + short_rows; ++k) {
      const bool is_short = k >= long_rows;
      rows_.push_back({is_short, 0, is_short ? k - long_rows : k, is_short});
      weights_[k] = is_short ? 1.0 : first_weight;
    }
  }

  int parameter_count() const override { return parameters_; }
  const std::vector<Row>& rows() const override { return rows_; }
  Eigen::VectorXd weights() const override { return weights_; }
  mechanics::PathStatus evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& r,
                                 RowMatrix* j) override {
    r.resize(row_count());
    if (j) j->setZero(row_count(), parameters_);
    for (int k = 0; k < row_count(); ++k) {
      r[k] = p[0] + p[1] * t(k) - measured[k];
      if (j) j->row(k).head<2>() << 1.0, t(k);
    }
    return mechanics::PathStatus::ok;
  }
  /// The short curve alone reaches far.
  double t(int k) const {
    const Row& row = rows_[static_cast<std::size_t>(k)];
    return row.curve == 0 ? 0.01 * row.frame : 1.0 + 0.1 * row.frame;
  }

  Eigen::VectorXd measured;

 private:
  int parameters_;
  std::vector<Row> rows_;
  Eigen::VectorXd weights_;
};

/// A document with two free parameters.
model::Model two_parameters() {
  model::Model model = model::preset("cloth_stvk").value();
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i]->value = 1.0;
    parameters[i]->fixed = i >= 2;
    parameters[i]->lower.reset();
    parameters[i]->upper.reset();
  }
  return model;
}

constexpr double kTruth[] = {2.0, 5.0};

/// Estimates of many seeds: their scatter beside what each fit says of its own.
struct Scatter {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
  Eigen::Vector2d said = Eigen::Vector2d::Zero();
};

Scatter scatter(double first_weight, const FitOptions& options, double outliers) {
  constexpr int kSeeds = 500;
  const model::Model model = two_parameters();
  Line line(static_cast<int>(parameters_of(model).size()), 200, 50, first_weight);
  std::vector<Eigen::Vector2d> found;
  Scatter result;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    for (int k = 0; k < line.row_count(); ++k) {
      line.measured[k] = kTruth[0] + kTruth[1] * line.t(k) + normal(random);
      if (uniform(random) < outliers) line.measured[k] += 20.0;
    }
    const FitResult fitted = fit(line, model, options);
    EXPECT_TRUE(fitted.converged) << fitted.message;
    found.emplace_back(fitted.parameters.head<2>());
    result.mean += found.back() / kSeeds;
    result.said += fitted.std_error.head<2>() / kSeeds;
  }
  for (const Eigen::Vector2d& p : found)
    result.deviation += (p - result.mean).cwiseAbs2() / (kSeeds - 1);
  result.deviation = result.deviation.cwiseSqrt();
  return result;
}

/// Five deviations of what 500 seeds tell of a scatter, and the most that counting neighbours that
/// happen to agree as fewer rows has added.
constexpr double kBand = 0.16 + 0.08;

TEST(LeastSquares, ErrorsAreRightUnderWeights) {
  const double weight = 25.0;
  const Scatter weighted = scatter(weight, {}, 0.0);
  // what (J'WJ)^-1 alone would say is far off, so the test can fail
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  const Line line(2, 200, 50, weight);
  for (int k = 0; k < line.row_count(); ++k) {
    const Eigen::Vector2d row(1.0, line.t(k));
    normal += line.weights()[k] * row * row.transpose();
  }
  const Eigen::Matrix2d naive = normal.inverse();
  EXPECT_GT(std::abs(std::sqrt(naive(0, 0)) / weighted.deviation[0] - 1.0), 1.5 * kBand);
  for (int p = 0; p < 2; ++p) {
    EXPECT_NEAR(weighted.mean[p], kTruth[p], 5.0 * weighted.deviation[p] / std::sqrt(500.0));
    EXPECT_NEAR(weighted.said[p] / weighted.deviation[p], 1.0, kBand) << p;
  }
}

TEST(LeastSquares, RobustLossesBearOutliersAndSaySo) {
  const Scatter plain = scatter(1.0, {}, 0.1);
  for (const RobustLoss& loss : {RobustLoss{Loss::huber, 1.345}, RobustLoss{Loss::cauchy, 2.385}}) {
    FitOptions options;
    options.loss = loss;
    const Scatter robust = scatter(1.0, options, 0.1);
    EXPECT_LT(std::abs(robust.mean[0] - kTruth[0]), 0.3 * std::abs(plain.mean[0] - kTruth[0]));
    for (int p = 0; p < 2; ++p) {
      EXPECT_LT(robust.deviation[p], 0.5 * plain.deviation[p]) << p;
      EXPECT_NEAR(robust.said[p] / robust.deviation[p], 1.0, kBand) << p;
    }
    const Scatter clean = scatter(1.0, options, 0.0);
    const Scatter best = scatter(1.0, {}, 0.0);
    for (int p = 0; p < 2; ++p) EXPECT_LT(clean.deviation[p], 1.1 * best.deviation[p]) << p;
  }
}

TEST(LeastSquares, LossesHaveTheDerivativesTheyClaim) {
  for (const Loss kind : {Loss::none, Loss::huber, Loss::cauchy}) {
    for (const double s : {0.3, 1.7, 2.0, 9.0, 400.0}) {
      const RobustLoss loss{kind, 1.345};
      const double h = 1e-5 * s;
      const LossValue at = loss_at(loss, s);
      const LossValue high = loss_at(loss, s + h), low = loss_at(loss, s - h);
      EXPECT_NEAR(at.by_s, (high.rho - low.rho) / (2.0 * h), 1e-8);
      EXPECT_NEAR(at.by_ss, (high.by_s - low.by_s) / (2.0 * h), 1e-8);
      EXPECT_LE(at.rho, s);
    }
  }
}

/// The compressed rows have the cost, gradient and normal matrix of all rows.
TEST(LeastSquares, FewRowsSayWhatAllRowsSay) {
  Line line(2, 300, 70, 0.3);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < line.row_count(); ++k) line.measured[k] = 4.0 * normal(random);
  const std::vector<int> free = {0, 1};
  const Eigen::Vector2d x(1.5, -2.0), scale(2.0, 0.5);
  for (const RobustLoss& loss : {RobustLoss{}, RobustLoss{Loss::huber, 1.345}}) {
    Eigen::VectorXd all(2);
    const Eigen::VectorXd scales = scale;
    const Eigen::VectorXd weights = line.weights();
    Objective objective(line, all, free, scales, weights, loss);
    Eigen::VectorXd few(3), alone(3);
    RowMatrix few_j(3, 2);
    ASSERT_TRUE(objective.evaluate(x.data(), few.data(), few_j.data()));
    ASSERT_TRUE(objective.evaluate(x.data(), alone.data(), nullptr));
    Eigen::VectorXd r;
    RowMatrix j;
    ASSERT_EQ(line.evaluate(x.cwiseProduct(scale), r, &j), mechanics::PathStatus::ok);
    double cost = 0.0;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (int k = 0; k < line.row_count(); ++k) {
      const LossValue value = loss_at(loss, r[k] * r[k]);
      cost += weights[k] * value.rho;
      gradient += weights[k] * value.by_s * r[k] * j.row(k).transpose().cwiseProduct(scale);
    }
    EXPECT_NEAR(few.squaredNorm(), cost, 1e-12 * cost);
    EXPECT_NEAR(alone.squaredNorm(), cost, 1e-12 * cost);
    EXPECT_LT((few_j.transpose() * few - gradient).norm(), 1e-12 * gradient.norm());
    if (loss.kind != Loss::none) continue;
    const Eigen::Matrix2d all_j =
        scale.asDiagonal() * j.transpose() * weights.asDiagonal() * j * scale.asDiagonal();
    EXPECT_LT((few_j.transpose() * few_j - all_j).norm(), 1e-12 * all_j.norm());
  }
}

/// r = p^2 - 8.41, without an equilibrium beyond 3: the first step goes to 8.7.
class Cliff final : public ResidualFunction {
 public:
  explicit Cliff(int parameters) : parameters_(parameters), rows_(1) {}
  int parameter_count() const override { return parameters_; }
  const std::vector<Row>& rows() const override { return rows_; }
  mechanics::PathStatus evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& r,
                                 RowMatrix* j) override {
    if (p[0] > 3.0) {
      ++failures;
      return mechanics::PathStatus::no_equilibrium;
    }
    r.setConstant(1, p[0] * p[0] - 8.41);
    if (j) {
      j->setZero(1, parameters_);
      (*j)(0, 0) = 2.0 * p[0];
    }
    return mechanics::PathStatus::ok;
  }

  int failures = 0;

 private:
  int parameters_;
  std::vector<Row> rows_;
};

TEST(LeastSquares, AFailedEquilibriumShortensTheStep) {
  model::Model model = two_parameters();
  parameters_of(model)[0]->value = 0.5;
  parameters_of(model)[1]->fixed = true;
  for (const FitMethod method : {FitMethod::trust_region, FitMethod::gauss_newton,
                                 FitMethod::gauss_newton_damped, FitMethod::bounded_marquardt}) {
    Cliff cliff(static_cast<int>(parameters_of(model).size()));
    FitOptions options;
    options.method = method;
    const FitResult result = fit(cliff, model, options);
    ASSERT_TRUE(result.usable) << result.message;
    EXPECT_TRUE(result.converged) << result.message;
    EXPECT_NEAR(result.parameters[0], 2.9, 1e-6);
    EXPECT_GT(cliff.failures, 0);
  }
}

/// The full step crosses the bound, and cut off there it goes up: p0 is found with p1 held.
TEST(LeastSquares, AllMethodsFindTheOptimumAtABound) {
  model::Model model = two_parameters();
  parameters_of(model)[1]->lower = 0.0;
  Line line(static_cast<int>(parameters_of(model).size()), 100, 20, 1.0);
  for (int k = 0; k < line.row_count(); ++k) line.measured[k] = 4.0 - 3.0 * line.t(k);
  FitOptions options;
  options.residual_stop = 1e-10;
  options.tolerance = 1e-12;
  const FitResult ceres = fit(line, model, options);
  options.method = FitMethod::gauss_newton;
  const FitResult own = fit(line, model, options);
  options.method = FitMethod::bounded_marquardt;
  const FitResult exact = fit(line, model, options);
  for (const FitResult& found : {ceres, own, exact}) {
    ASSERT_TRUE(found.usable && found.converged) << found.message;
    EXPECT_EQ(found.states[1], ParameterState::at_bound);
    EXPECT_NEAR(found.parameters[0], line.measured.mean(), 1e-9);
    EXPECT_NEAR(found.parameters[1], 0.0, 1e-9);
  }
}

/// A linear problem whose free optimum is across the bounds: the exact step finds within them what
/// one that is cut off there needs many evaluations for.
TEST(LeastSquares, AStepWithinTheBoundsIsOneEvaluation) {
  model::Model model = two_parameters();
  parameters_of(model)[0]->upper = 1.5;
  parameters_of(model)[1]->lower = 0.0;
  class Counted final : public ResidualFunction {
   public:
    explicit Counted(int parameters) : line(parameters, 100, 20, 1.0) {}
    int parameter_count() const override { return line.parameter_count(); }
    const std::vector<Row>& rows() const override { return line.rows(); }
    mechanics::PathStatus evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& r,
                                   RowMatrix* j) override {
      if (!j) ++evaluations;
      return line.evaluate(p, r, j);
    }
    Line line;
    int evaluations = 0;
  };
  Counted counted(static_cast<int>(parameters_of(model).size()));
  for (int k = 0; k < counted.row_count(); ++k)
    counted.line.measured[k] = 2.0 + 3.0 * counted.line.t(k);
  FitOptions options;
  options.method = FitMethod::bounded_marquardt;
  options.tolerance = 1e-4;
  const FitResult found = fit(counted, model, options);
  ASSERT_TRUE(found.usable && found.converged) << found.message;
  EXPECT_DOUBLE_EQ(found.parameters[0], 1.5);
  // slope alone, through 1.5
  double along = 0.0, length = 0.0;
  for (int k = 0; k < counted.row_count(); ++k) {
    const double t = counted.line.t(k);
    along += t * (counted.line.measured[k] - 1.5);
    length += t * t;
  }
  ASSERT_GT(along / length, 3.1);  // not the free optimum's
  EXPECT_NEAR(found.parameters[1], along / length, 1e-3);
  EXPECT_LE(counted.evaluations, 3);  // the start, the step, and one for the damping
}

}  // namespace
}  // namespace tenter::estimation
