// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/added_columns.h"

#include <gtest/gtest.h>

#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/screening/normal.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::data_of;

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

/// By the last parameter, as a fit to the whole model has it.
Eigen::VectorXd last_column(const model::Model& model, const FieldData& data) {
  auto evaluator = estimation::SequenceEvaluator::make(model, data.sequences);
  EXPECT_TRUE(evaluator);
  Eigen::VectorXd residuals;
  estimation::RowMatrix jacobian;
  EXPECT_EQ(evaluator->evaluate(estimation::parameter_values(model), residuals, &jacobian),
            mechanics::PathStatus::ok)
      << evaluator->failure();
  return jacobian.rightCols<1>();
}

/// What the rig does to the sheet, what is read of forces (late, too) and of points.
std::vector<model::SensorCorrection> faults_of(const model::Model& base) {
  std::vector<model::SensorCorrection> faults;
  const auto add = [&](const char* type, const char* component) {
    faults.push_back(new_sheet_correction(base, type, component, ""));
  };
  for (const char* type : {"mass_scale", "camera_pose", "camera_scale", "delay"}) add(type, "");
  for (const char* type : {"clip_slip", "gain", "saturation"}) add(type, "stretch_v_2");
  faults[4].parameters[1].value = 3.0;   // slips in the fourth frame
  faults[6].parameters[1].value = 0.02;  // N: most of the pull is above
  return faults;
}

class AddedColumns : public ::testing::Test {
 protected:
  /// Derivatives by parameters of what is added against solves with a little of it.
  static void check(const model::Model& base) {
    const FieldData data = data_of(testing::sheets_of(
        {.model = compliant_cloth(), .protocols = {"stretch_v"}, .frames = 7}, base));
    const auto fit = predict_field(base, data, {}, {});
    ASSERT_TRUE(fit) << fit.error().message;
    Added added;
    added.terms = {switched_off("coupling", "green_pair", "bilinear"),
                   switched_off("stiffening", "green_trace", "linear"),
                   switched_off("lag", "green_v", "dahl"),
                   switched_off("flow", "green_v", "plastic_set"),
                   switched_off("slow", "green_v", "maxwell"),
                   switched_off("drag", "green_v", "kelvin_voigt")};
    added.corrections = faults_of(base);
    // the first parameter of each alone, and of the pose a turn and a shift
    std::vector<std::pair<std::size_t, std::size_t>> of_terms, of_corrections;  // and its parameter
    int place = 0;
    for (std::size_t t = 0; t < added.terms.size(); ++t) {
      added.wanted_of_terms.push_back(place);
      of_terms.emplace_back(t, 0);
      place += static_cast<int>(added.terms[t].law.parameters.size());
    }
    place = 0;
    for (std::size_t c = 0; c < added.corrections.size(); ++c) {
      const model::SensorCorrection& fault = added.corrections[c];
      for (const int p : {0, 1, 5}) {
        if (p > 0 && fault.type != "camera_pose") continue;
        added.wanted_of_corrections.push_back(place + p);
        of_corrections.emplace_back(c, static_cast<std::size_t>(p));
      }
      place += static_cast<int>(fault.parameters.size());
    }
    const auto columns = added_columns(*fit, data, added, 1);
    ASSERT_TRUE(columns) << columns.error().message;
    Eigen::Index column = 0;
    const auto compare = [&](const std::string& id, const Eigen::VectorXd& change) {
      ASSERT_GT(change.norm(), 1e-3) << id;
      EXPECT_LT((columns->col(column) - change).norm(), 5e-4 * change.norm()) << id;
      ++column;
    };
    const auto difference = [&](double step, const auto& with) {
      return ((residuals_with(with(step), data) - residuals_with(with(-step), data)) / (2.0 * step))
          .eval();
    };
    for (const auto& [t, p] : of_terms)
      compare(added.terms[t].id, difference(5e-3, [&, t = t, p = p](double by) {  // of some ten N/m
                model::Model model = base;
                model.terms.push_back(added.terms[t]);
                model.terms.back().law.parameters[p].value += by;
                return model;
              }));
    for (const auto& [c, p] : of_corrections) {
      const std::string& type = added.corrections[c].type;
      const auto with = [&, c = c, p = p](double by) {
        model::Model model = base;
        model.corrections.push_back(added.corrections[c]);
        model.corrections.back().parameters[p].value += by;
        return model;
      };
      // forces are interpolated, with a corner at each frame, where a delay starts: one side counts
      if (type == "delay")
        compare(type, last_column(with(0.0), data));
      else
        compare(type, difference(type == "mass_scale" ? 1e-2 : 1e-5, with));
    }
  }
};

model::Model rubbing_cloth() {
  model::Model base = compliant_cloth();
  base.terms.push_back(new_term(base, "friction", "green_v", 0.0, "dahl"));
  set_parameter(base.terms.back().law, "a", 0.3);
  set_parameter(base.terms.back().law, "b", 0.1);
  set_parameter(base.terms.back().law, "tau", 0.01);
  return base;
}

TEST_F(AddedColumns, OfAnElasticModelAreThoseOfSolves) {
  check(compliant_cloth());
}

TEST_F(AddedColumns, OfAModelThatRemembersAreThoseOfSolves) {
  check(rubbing_cloth());
}

TEST_F(AddedColumns, OfAModelWithFaultsOfItsOwnAreThoseOfSolves) {
  model::Model base = rubbing_cloth();
  base.corrections.push_back(new_sheet_correction(base, "gain", "stretch_v_1", ""));
  base.corrections.back().parameters[0].value = 1.1;
  base.corrections.push_back(new_sheet_correction(base, "camera_scale", "", ""));
  base.corrections.back().parameters[0].value = 0.97;
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
