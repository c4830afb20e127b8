// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/term_columns.h"

#include <gtest/gtest.h>

#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/screening/normal.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;

FieldData data_of(const SheetRequest& request) {
  FieldData data;
  for (const SheetSequence& s : request.sequences) {
    data.sequences.push_back(s.sequence);
    for (auto& frame : data.sequences.back().frames) frame.duration_s = 1.0;
    data.ids.push_back(s.id);
    data.protocols.push_back(s.title);
    data.has_clock.push_back(false);
  }
  return data;
}

model::Term switched_off(const char* id, const char* measure, const char* law) {
  model::Term term = new_term({}, id, measure, 0.0, law);
  for (model::Parameter& p : term.law.parameters)
    if (!p.lower || *p.lower <= 0.0) p.value = 0.0;
  return term;
}

/// Residuals of a model with the terms' first parameters at these values.
Eigen::VectorXd residuals_with(const model::Model& model, const FieldData& data) {
  auto evaluator =
      estimation::SequenceEvaluator::make(model, data.sequences, {.tolerance_N = 1e-11});
  EXPECT_TRUE(evaluator);
  Eigen::VectorXd residuals;
  EXPECT_EQ(evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr),
            mechanics::PathStatus::ok)
      << evaluator->failure();
  return residuals;
}

class TermColumns : public ::testing::Test {
 protected:
  /// Derivatives by the first parameter of each added term against a solve with a little of it.
  static void check(const model::Model& base) {
    const FieldData data = data_of(testing::sheets_of(
        {.model = compliant_cloth(), .protocols = {"stretch_v"}, .frames = 7}, base));
    const auto fit = predict_field(base, data, {}, {});
    ASSERT_TRUE(fit) << fit.error().message;
    const std::vector<model::Term> added = {
        switched_off("coupling", "green_pair", "bilinear"),
        switched_off("stiffening", "green_trace", "linear"), switched_off("lag", "green_v", "dahl"),
        switched_off("flow", "green_v", "plastic_set"), switched_off("slow", "green_v", "maxwell")};
    const auto columns = term_columns(*fit, data, added, {}, 1);
    ASSERT_TRUE(columns) << columns.error().message;
    Eigen::Index column = 0;
    for (const model::Term& term : added) {
      constexpr double kStep = 5e-3;  // of stiffnesses of some ten N/m
      model::Model more = base;
      more.terms.push_back(term);
      model::Model less = more;
      more.terms.back().law.parameters[0].value = kStep;
      less.terms.back().law.parameters[0].value = -kStep;
      const Eigen::VectorXd change =
          (residuals_with(more, data) - residuals_with(less, data)) / (2.0 * kStep);
      ASSERT_GT(change.norm(), 1e-3) << term.id;
      EXPECT_LT((columns->col(column) - change).norm(), 5e-4 * change.norm()) << term.id;
      column += static_cast<Eigen::Index>(term.law.parameters.size());
    }
  }
};

TEST_F(TermColumns, OfAnElasticModelAreThoseOfSolves) {
  check(compliant_cloth());
}

TEST_F(TermColumns, OfAModelThatRemembersAreThoseOfSolves) {
  model::Model base = compliant_cloth();
  base.terms.push_back(new_term(base, "friction", "green_v", 0.0, "dahl"));
  set_parameter(base.terms.back().law, "a", 0.3);
  set_parameter(base.terms.back().law, "b", 0.1);
  set_parameter(base.terms.back().law, "tau", 0.01);
  check(base);
}

/// Of white noise every reading counts; of a field that is one number, one does.
TEST(Structure, CountsWhatIsIndependent) {
  const FieldData data = data_of(testing::sheets_of(
      {.model = compliant_cloth(), .protocols = {"stretch_v"}}, compliant_cloth()));
  const auto fit = predict_field(compliant_cloth(), data, {}, {});
  ASSERT_TRUE(fit);
  const auto rows = static_cast<Eigen::Index>(fit->rows.size());
  ASSERT_GT(rows, 1000);
  Normal normal(3);
  Eigen::VectorXd noise(rows);
  for (Eigen::Index k = 0; k < rows; ++k) noise[k] = normal();
  EXPECT_GT(independent_rows(data.sequences, fit->rows, noise), 0.6 * static_cast<double>(rows));
  const Eigen::VectorXd one = Eigen::VectorXd::Constant(rows, 1.0);
  EXPECT_LT(independent_rows(data.sequences, fit->rows, one), 0.02 * static_cast<double>(rows));
  for (const Structure& s : structure_of(data.sequences, fit->rows, one)) {
    EXPECT_NEAR(s.fixed, 1.0, 1e-9);
    EXPECT_NEAR(s.in_time, 1.0, 1e-9);
  }
  for (const Structure& s : structure_of(data.sequences, fit->rows, noise)) {
    EXPECT_NEAR(s.fixed, 0.0, 0.1);
    EXPECT_NEAR(s.in_time, 0.0, 0.3);
    EXPECT_NEAR(s.at_edges, 0.0, 0.2);
  }
}

}  // namespace
}  // namespace tenter::diagnosis
