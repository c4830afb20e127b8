// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>

#include "server/estimation/friction_tests/friction_estimate.h"

namespace tenter::estimation {
namespace {

/// r = J (p - q) with correlated columns, whose least would lie at a negative a.
class StraightErrors final : public ResidualFunction {
 public:
  StraightErrors()
      : jacobian_(kRows, kFrictionParameters), least_(flat({3.0, 2.0, -0.5, 4.0, 5.0})) {
    for (int i = 0; i < kRows; ++i) {
      const double t = (i + 0.5) / kRows;
      jacobian_.row(i) << std::sin(7.0 * t), std::cos(9.0 * t), t, t * t, 0.0, std::sin(15.0 * t);
      rows_.push_back({0, 0, i, i});
    }
  }
  int parameter_count() const override { return kFrictionParameters; }
  const std::vector<Row>& rows() const override { return rows_; }
  mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals,
                                 RowMatrix* jacobian) override {
    residuals = jacobian_ * (parameters - least_);
    if (jacobian != nullptr) *jacobian = jacobian_;
    return mechanics::PathStatus::ok;
  }
  /// Standard errors with k1, k2, a, b and tau all free.
  Eigen::VectorXd free_errors() const {
    const Eigen::MatrixXd moving = jacobian_(Eigen::all, std::vector<int>{kK1, kK2, kA, kB, kTau});
    return (moving.transpose() * moving).inverse().diagonal().cwiseSqrt();
  }

 private:
  static constexpr int kRows = 4000;
  RowMatrix jacobian_;
  Eigen::VectorXd least_;
  std::vector<Row> rows_;
};

// With a at its bound the others are no better known than if it were free: that it is not below
// zero does not say that it is zero.
TEST(FrictionEstimate, NumbersBesideOneAtItsBoundAreAsUncertainAsIfItWereFree) {
  StraightErrors errors;
  const model::Model model = with_values(friction_model("bend_v"), {2.0, 1.0, 1.0, 3.0, 4.0});
  FrictionEstimate estimate;
  estimate.fit = fit(errors, model, {});
  ASSERT_TRUE(estimate.fit.usable);
  ASSERT_EQ(estimate.fit.states[kA], ParameterState::at_bound);
  judge([] { return std::make_unique<StraightErrors>(); }, model, {.profiles = false}, estimate);
  const Eigen::VectorXd wanted = errors.free_errors();
  const double rows = errors.row_count();
  const double inflation_of = std::sqrt(rows / (estimate.fit.effective_rows - 4.0));
  constexpr int kPlaceOfA = 2;
  for (int k = 0; k < 5; ++k) {
    const FrictionNumber& number = estimate.numbers[static_cast<std::size_t>(k)];
    ASSERT_TRUE(number.hi) << number.name;
    EXPECT_NEAR((*number.hi - number.value) / 1.959963984540054, inflation_of * wanted[k],
                1e-6 * wanted[k])
        << number.name;
    EXPECT_EQ(number.is_told, k != kPlaceOfA) << number.name;
  }
  EXPECT_FALSE(estimate.numbers[kPlaceOfA].lo);
  EXPECT_NE(estimate.numbers[kPlaceOfA].words.find("at most"), std::string::npos);
  // which is worth saying: held at its bound it would make b look far better known
  EXPECT_GT(wanted[3], 2.0 * estimate.fit.std_error[kB]);
}

}  // namespace
}  // namespace tenter::estimation
