// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/hold_out.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

const std::vector<double> kCloth = {600.0, 800.0, 150.0, 100.0};

std::shared_ptr<DataSet> three_protocols() {
  auto data = testing::data_of(
      {testing::loop_capture({.group = "a"}), testing::loop_capture({.peak = 0.04, .group = "b"}),
       testing::loop_capture({.runs = 2, .peak = 0.08, .group = "c"})},
      0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 4, *data);
  return data;
}

/// Members that a fold leaves out, by a name that the rows give.
template <class Name>
std::set<std::string> left_out(const Folds& folds, std::size_t k, const std::vector<Row>& rows,
                               Name name) {
  std::set<std::string> names;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (folds.training[k][static_cast<Eigen::Index>(r)] == 0.0) names.insert(name(rows[r]));
  return names;
}

TEST(Folds, EveryRowIsLeftOutOnce) {
  const auto data = three_protocols();
  const auto rows = data->rows();
  for (const std::string& kind : fold_kinds()) {
    const Folds folds = make_folds(*data, rows, kind);
    ASSERT_FALSE(folds.training.empty()) << kind;
    EXPECT_LE(folds.training.size(), 8U);
    Eigen::VectorXd times = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
    for (const Eigen::VectorXd& training : folds.training) times.array() += 1.0 - training.array();
    EXPECT_TRUE((times.array() == 1.0).all()) << kind;
  }
}

TEST(Folds, LeaveOutWhatTheyAreCalled) {
  const auto data = three_protocols();
  const auto rows = data->rows();
  const auto run_of = [&](const Row& row) {
    const Curves& c = data->curves[static_cast<std::size_t>(row.curve)];
    return c.blocks[static_cast<std::size_t>(c.block_of[static_cast<std::size_t>(row.frame)])].run;
  };
  const Folds protocols = make_folds(*data, rows, "protocols");
  ASSERT_EQ(protocols.training.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(
        left_out(protocols, k, rows, [](const Row& r) { return std::to_string(r.curve); }).size(),
        1U);
  const Folds repeats = make_folds(*data, rows, "repeats");
  ASSERT_EQ(repeats.training.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(
        left_out(repeats, k, rows, [&](const Row& r) { return std::to_string(run_of(r)); }).size(),
        1U);
  EXPECT_EQ(make_folds(*data, rows, "runs").training.size(), 8U);
  EXPECT_EQ(make_folds(*data, rows, "blocks").training.size(), 8U);  // sixteen, two by two
}

TEST(Folds, OfTooFewMembersAreNone) {
  const auto data = testing::data_of({testing::loop_capture({.runs = 1})}, 0.2);
  const auto rows = data->rows();
  EXPECT_TRUE(make_folds(*data, rows, "protocols").training.empty());
  EXPECT_TRUE(make_folds(*data, rows, "repeats").training.empty());
  EXPECT_TRUE(make_folds(*data, rows, "runs").training.empty());
  EXPECT_EQ(make_folds(*data, rows, "blocks").training.size(), 2U);
}

model::Model cloth_with_shear_held() {
  model::Model model = testing::preset_with("stvk_orthotropic", kCloth);
  parameters_of(model)[3]->fixed = true;
  return model;
}

TEST(AddedParameters, AreThoseThatAreNewOrFreed) {
  const model::Model small = cloth_with_shear_held();
  model::Model large = small;
  EXPECT_TRUE(added_parameters(large, small).empty());
  parameters_of(large)[3]->fixed = false;
  testing::add_correction(large, "offset", "x", 0.0);
  EXPECT_EQ(added_parameters(large, small), (std::vector<std::size_t>{3, 4}));
}

TEST(KeepDetermined, DropsFoldsThatAloneShowAnEffect) {
  const auto data = three_protocols();
  // an offset of the third capture only: without it nothing shows the offset
  model::Model model = cloth_with_shear_held();
  testing::add_correction(model, "offset", "x", 1.0);
  model.corrections.back().capture = data->curves[2].id;
  testing::measure_with(model, 0.2, 6, *data);
  auto evaluator = Evaluator::make(model, data);
  ASSERT_TRUE(evaluator);
  const FitResult found = fit(*evaluator, model, {});
  ASSERT_TRUE(found.converged);
  Folds folds = make_folds(*data, evaluator->rows(), "protocols");
  ASSERT_EQ(folds.training.size(), 3U);
  keep_determined(folds, found, added_parameters(model, cloth_with_shear_held()));
  ASSERT_EQ(folds.training.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto names =
        left_out(folds, k, evaluator->rows(), [](const Row& r) { return std::to_string(r.curve); });
    EXPECT_FALSE(names.contains("2"));
  }
  // blocks show it often enough to leave any out
  Folds blocks = make_folds(*data, evaluator->rows(), "blocks");
  keep_determined(blocks, found, added_parameters(model, cloth_with_shear_held()));
  EXPECT_EQ(blocks.training.size(), 8U);
}

TEST(KeepDetermined, DropsFoldsThatTakeAllThatAParameterActsOn) {
  const auto data = three_protocols();
  // factors of the second and the third capture: either could be told without the other's data
  model::Model model = cloth_with_shear_held();
  for (const std::size_t curve : {1U, 2U}) {
    testing::add_correction(model, "gain", "", 1.2);
    model.corrections.back().id += std::to_string(curve);
    model.corrections.back().capture = data->curves[curve].id;
  }
  testing::measure_with(model, 0.2, 6, *data);
  auto evaluator = Evaluator::make(model, data);
  ASSERT_TRUE(evaluator);
  const FitResult found = fit(*evaluator, model, {});
  ASSERT_TRUE(found.converged);
  Folds folds = make_folds(*data, evaluator->rows(), "protocols");
  ASSERT_EQ(folds.training.size(), 3U);
  keep_determined(folds, found, added_parameters(model, cloth_with_shear_held()));
  for (std::size_t k = 0; k < folds.training.size(); ++k)
    EXPECT_EQ(
        left_out(folds, k, evaluator->rows(), [](const Row& r) { return std::to_string(r.curve); }),
        std::set<std::string>{"0"});
}

TEST(CrossValidation, OfTheTrueModelMissesTheNoiseAndNoMore) {
  const auto data = three_protocols();
  const model::Model model = cloth_with_shear_held();
  auto evaluator = Evaluator::make(model, data);
  ASSERT_TRUE(evaluator);
  for (const char* kind : {"protocols", "repeats", "blocks"}) {
    const HeldOut held =
        cross_validate(*evaluator, model, make_folds(*data, evaluator->rows(), kind), {});
    ASSERT_TRUE(held.usable) << kind;
    EXPECT_NEAR(held.chi2 / evaluator->row_count(), 1.0, 0.15) << kind;
    EXPECT_TRUE((held.left_out.array() == 1.0).all());
    EXPECT_TRUE(held.residuals.allFinite());
  }
}

TEST(CrossValidation, ExtrapolationByAWrongModelCosts) {
  // two ratios of the stretches: only the coupling explains both
  auto data = testing::data_of(
      {testing::loop_capture({.group = "a"}), testing::loop_capture({.peak = 0.04, .group = "b"}),
       testing::loop_capture({.transverse_free = true, .group = "c"})},
      0.2);
  testing::measure_with(cloth_with_shear_held(), 0.2, 4, *data);
  model::Model wrong = cloth_with_shear_held();
  parameters_of(wrong)[2]->value = 0.0;
  parameters_of(wrong)[2]->fixed = true;
  double chi2[2] = {0.0, 0.0};
  int k = 0;
  for (const model::Model& model : {cloth_with_shear_held(), wrong}) {
    auto evaluator = Evaluator::make(model, data);
    ASSERT_TRUE(evaluator);
    const Folds folds = make_folds(*data, evaluator->rows(), "protocols");
    chi2[k++] = cross_validate(*evaluator, model, folds, {}).chi2;
  }
  EXPECT_GT(chi2[1], 2.0 * chi2[0]);
}

TEST(CrossValidation, WithoutFoldsIsNotUsable) {
  const auto data = three_protocols();
  auto evaluator = Evaluator::make(cloth_with_shear_held(), data);
  ASSERT_TRUE(evaluator);
  EXPECT_FALSE(cross_validate(*evaluator, cloth_with_shear_held(), {}, {}).usable);
}

/// Fails where a fit begins anew for the second time.
class SecondFold final : public ResidualFunction {
 public:
  explicit SecondFold(ResidualFunction& inner) : inner_(inner) {}
  int parameter_count() const override { return inner_.parameter_count(); }
  const std::vector<Row>& rows() const override { return inner_.rows(); }
  void set_accuracy(Accuracy accuracy) override {
    if (accuracy == Accuracy::stepping && last_ == Accuracy::exact) ++fits_;
    last_ = accuracy;
  }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override {
    if (fits_ == 2) return mechanics::PathStatus::no_equilibrium;
    return inner_.evaluate(parameters, residuals, jacobian);
  }

 private:
  ResidualFunction& inner_;
  Accuracy last_ = Accuracy::exact;
  int fits_ = 0;
};

TEST(CrossValidation, SaysWhichFoldFailed) {
  const auto data = three_protocols();
  auto evaluator = Evaluator::make(cloth_with_shear_held(), data);
  ASSERT_TRUE(evaluator);
  SecondFold failing(*evaluator);
  const Folds folds = make_folds(*data, evaluator->rows(), "protocols");
  ASSERT_EQ(folds.training.size(), 3U);
  const HeldOut found = cross_validate(failing, cloth_with_shear_held(), folds, {});
  EXPECT_FALSE(found.usable);
  EXPECT_EQ(found.failed_fold, 1);
}

}  // namespace
}  // namespace tenter::estimation
