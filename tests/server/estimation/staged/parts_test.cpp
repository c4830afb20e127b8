// SPDX-License-Identifier: GPL-3.0-or-later
// What staged fits are made of: bounded least squares, ties, strain histograms, finer splines.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/presets.h"
#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/splines/knot_choice.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/splines/strain_histogram.h"
#include "server/estimation/staged/stage.h"
#include "server/mechanics/law.h"
#include "tests/server/estimation/staged/small_rig.h"
#include "tests/server/estimation/whole_differences.h"

namespace tenter::estimation {
namespace {

TEST(BoundedLeastSquares, MeetsTheConditionsOfTheMinimum) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  int bounds_met = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const int n = 3 + trial % 8;
    const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(40, n, [&] { return normal(random); });
    const Eigen::VectorXd b =
        Eigen::VectorXd::NullaryExpr(40, [&] { return 3.0 * normal(random); });
    const Eigen::VectorXd lower = Eigen::VectorXd::Constant(n, -0.1);
    const Eigen::VectorXd upper = Eigen::VectorXd::Constant(n, 0.3);
    BoundedLeastSquares problem(n);
    problem.add(a.topRows(15), b.head(15));
    problem.add(a.bottomRows(25), b.tail(25));
    const BoundedSolution s = problem.solve(lower, upper);
    EXPECT_EQ(s.rank, n);
    EXPECT_NEAR(s.residual, (a * s.x - b).norm(), 1e-12 * b.norm());
    const Eigen::VectorXd gradient = a.transpose() * (a * s.x - b);
    const double scale = (a.transpose() * b).norm();
    for (int i = 0; i < n; ++i) {
      if (s.x[i] <= -0.1) {
        EXPECT_GE(gradient[i], -1e-10 * scale);
      } else if (s.x[i] >= 0.3) {
        EXPECT_LE(gradient[i], 1e-10 * scale);
      } else {
        EXPECT_NEAR(gradient[i], 0.0, 1e-10 * scale);
      }
      bounds_met += s.is_at_bound[static_cast<std::size_t>(i)] ? 1 : 0;
    }
  }
  EXPECT_GT(bounds_met, 20);
}

TEST(BoundedLeastSquares, KeepsTheStartWhereNothingIsSaid) {
  BoundedLeastSquares problem(3);
  Eigen::MatrixXd a(2, 3);
  a << 1.0, 1.0, 0.0, 2.0, 2.0, 0.0;
  problem.add(a, Eigen::Vector2d(4.0, 8.0));
  const Eigen::VectorXd start = Eigen::Vector3d(1.0, 2.0, 7.0);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  const BoundedSolution s = problem.solve(-none, none, &start);
  EXPECT_EQ(s.rank, 1);
  EXPECT_NEAR(s.x[0], 1.5, 1e-12);
  EXPECT_NEAR(s.x[1], 2.5, 1e-12);
  EXPECT_EQ(s.x[2], 7.0);
}

TEST(ParameterTies, JacobianGoesThroughTheMap) {
  const model::Model model = curved_cloth();
  const auto measured = measured_in_rig(model, {});
  std::vector<Sequence> sequences;
  sequences.reserve(measured.size());
  for (const RoleSequence& s : measured) sequences.push_back(s.sequence);
  auto evaluator = SequenceEvaluator::make(model, sequences, {1, 1e-11}).value();
  auto ties = tie_terms(model, {{"weft", "warp"}, {"bend_weft", "bend_diagonal"}}).value();
  ASSERT_EQ(ties.map.rows(), 18);
  ASSERT_EQ(ties.map.cols(), 12);
  ties.map(5, 2) = 0.5;  // any linear map will do
  TiedFunction tied(evaluator, ties);
  testing::expect_whole_differences(tied, ties.values(), {0, 2, 7, 10});
}

TEST(ParameterTies, SaysWhatCannotBeTied) {
  const model::Model model = curved_cloth();
  EXPECT_EQ(tie_terms(model, {{"weft", "woof"}}).error().message,
            "there is no term \"woof\" to tie");
  EXPECT_EQ(tie_terms(model, {{"weft", "warp"}, {"warp", "shear"}}).error().message,
            "the term \"warp\" is tied twice");
  EXPECT_EQ(tie_terms(model, {{"weft", "shear"}}).error().message,
            "the terms \"weft\" and \"shear\" cannot share a curve: their laws differ in name, "
            "range, knots or size");
}

TEST(StrainHistogram, QuantilesCountAreaAndLeaveOutliersOut) {
  StrainHistogram histogram;
  for (int k = 0; k < 1000; ++k) histogram.add(0.001 * k, k < 500 ? 1.0 : 3.0);
  histogram.add(50.0, 1.0);
  histogram.add(-80.0, 1.0);
  histogram.sort();
  EXPECT_NEAR(histogram.quantile(0.25), 0.5, 0.003);
  const auto [lo, hi] = histogram.range(0.005);
  EXPECT_NEAR(lo, 0.009, 0.002);
  EXPECT_NEAR(hi, 0.9967, 0.002);
  const auto bins = histogram.bins(0.0, 1.0, 2);
  EXPECT_NEAR(bins[1] / bins[0], 3.0, 0.02);
}

TEST(StrainHistogram, OfAPulledSheetIsItsElongation) {
  const model::Model model = curved_cloth();
  const RoleSequence pulled = measured_in_rig(Role::stretch_u, model, {});
  const auto bound = mechanics::MeshModel::make(model, pulled.sequence.cloth).value();
  mechanics::State state = pulled.sequence.start;
  for (Eigen::Index n = 0; n < state.x.size() / 3; ++n) state.x[3 * n] *= 1.06;
  const auto histograms = strain_histograms(bound, {state});
  ASSERT_EQ(histograms.size(), 6U);
  EXPECT_NEAR(histograms[0].quantile(0.5), (1.06 * 1.06 - 1.0) / 2.0, 1e-12);
  EXPECT_NEAR(histograms[1].quantile(0.5), 0.0, 1e-12);
}

double stress(const model::Law& description, double strain) {
  const auto law = mechanics::make_law(description, 1).value();
  std::vector<double> values;
  for (const model::Parameter& p : description.parameters) values.push_back(p.value);
  mechanics::LawOutput out{};
  mechanics::LawInput in;
  in.strain = &strain;
  in.parameters = values.data();
  law->evaluate(in, out);
  return out.stress[0];
}

TEST(SplineRefinement, KeepsTheCurveOfABSpline) {
  model::Law law = model::preset("cloth_stvk_spline")->terms[0].law;
  law.range_lo = -0.02;
  law.range_hi = 0.08;
  model::Law curve = as_constant(law);
  ASSERT_EQ(curve.parameters.size(), 1U);
  curve.parameters[0].value = 70.0;
  for (int points = 2; points <= 5; ++points) {
    const model::Law finer = with_points(curve, points).value();
    ASSERT_EQ(finer.parameters.size(), static_cast<std::size_t>(points));
    EXPECT_EQ(finer.parameters.back().name, "k" + std::to_string(points));
    for (const double strain : {-0.03, -0.01, 0.013, 0.05, 0.09})
      EXPECT_NEAR(stress(finer, strain), stress(curve, strain), 1e-9 * 70.0 * 0.09) << points;
    curve = finer;
    for (std::size_t k = 0; k < curve.parameters.size(); ++k)
      curve.parameters[k].value *= 1.0 + 0.3 * static_cast<double>(k);  // no constant any more
  }
  EXPECT_FALSE(with_points(model::preset("cloth_stvk")->terms[0].law, 3));
}

TEST(SplineRefinement, AKnotMoreKeepsTheCurveOfABSplineOnUnevenKnots) {
  model::Law law = model::preset("cloth_stvk_spline")->terms[0].law;
  law.range_lo = 0.0;
  law.range_hi = 0.1;
  model::Law curve = with_points(law, 5, {0.07}).value();
  for (std::size_t k = 0; k < 5; ++k)
    curve.parameters[k].value = 40.0 + 35.0 * static_cast<double>(k * k);
  const model::Law finer = with_points(curve, 6, {0.07, 0.09}).value();
  EXPECT_EQ(finer.knots, (std::vector<double>{0.07, 0.09}));
  for (const double strain : {-0.01, 0.02, 0.0712, 0.088, 0.093, 0.11})
    EXPECT_NEAR(stress(finer, strain), stress(curve, strain), 1e-9 * 600.0 * 0.1) << strain;
  // another curve than the even one, and back to even knots it is only near
  model::Law even = curve;
  even.knots.clear();
  EXPECT_GT(std::abs(stress(even, 0.05) - stress(curve, 0.05)), 0.01 * stress(curve, 0.05));
  EXPECT_TRUE(with_points(curve, 3)->knots.empty());
  EXPECT_FALSE(with_points(curve, 6, {0.07}));        // one is missing
  EXPECT_FALSE(with_points(curve, 6, {0.09, 0.07}));  // falling
  EXPECT_FALSE(with_points(curve, 6, {0.07, 0.1}));   // at the end
}

TEST(KnotChoice, IsWhereTheCostIs) {
  model::Law law = model::preset("cloth_stvk_spline")->terms[0].law;
  law.name = "hermite_stiffness";
  law.range_lo = 0.0;
  law.range_hi = 1.0;
  law = as_constant(law);
  StrainHistogram left;  // nothing below 0.6, then even
  for (int k = 0; k < 1000; ++k) left.add(0.001 * k, k < 600 ? 0.0 : 1.0);
  left.sort();
  const std::vector<double> one = inner_knots(law, 3, left);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NEAR(one[0], 0.8, 0.02);
  const model::Law three = with_points(law, 3, one).value();
  const std::vector<double> three_knots = inner_knots(three, 5, left);
  ASSERT_EQ(three_knots.size(), 3U);
  EXPECT_EQ(three_knots[1], one[0]);           // those that are there stay
  EXPECT_NEAR(three_knots[0], 0.7, 0.8 / 32);  // to a bin of the histogram
  EXPECT_NEAR(three_knots[2], 0.9, 0.02);
  EXPECT_EQ(inner_knots(law, 3, StrainHistogram{}), (std::vector<double>{0.5}));
  law.name = "bspline_stiffness";
  EXPECT_TRUE(inner_knots(law, 4, left).empty());
  EXPECT_EQ(inner_knots(law, 5, left).size(), 1U);
}

TEST(KnotChoice, KnotsGoWhereTheCurveBends) {
  model::Model truth = curved_cloth();
  model::Law& weft = truth.terms[0].law;
  weft.name = "hermite_stiffness";
  weft.parameters.resize(4);
  weft.knots = {0.018, 0.026};  // stiffens between these
  for (std::size_t k = 0; k < 4; ++k) weft.parameters[k].value = k < 2 ? 40.0 : 140.0;
  RigOptions rig;
  rig.frames = 24;
  rig.noise = 0.0;
  const RoleSequence pulled = measured_in_rig(Role::stretch_u, truth, rig);
  double cost[2];
  for (const bool from_data : {false, true}) {
    model::Model model = truth;
    weft = as_constant(weft);
    model.terms[0].law = weft;
    model.terms[0].law.range_lo = model.terms[0].law.range_hi = 0.0;
    StageOptions options;
    options.most_points = 6;
    options.knots_from_data = from_data;
    const auto record = fit_stage(model, {"stretch_u", {"weft"}, {}, {pulled}}, options);
    ASSERT_TRUE(record) << record.error().message;
    ASSERT_TRUE(record->done) << record->message;
    cost[from_data ? 1 : 0] = record->cost_after / record->rows;
    const model::Law& found = model.terms[0].law;
    EXPECT_EQ(found.knots.empty(), !from_data);
    if (!from_data) continue;
    ASSERT_GE(found.knots.size(), 2U);
    EXPECT_TRUE(std::any_of(found.knots.begin(), found.knots.end(),
                            [](double knot) { return knot > 0.014 && knot < 0.030; }));
    EXPECT_EQ(model::write_model(model::parse_model(model::write_model(model), "again").value()),
              model::write_model(model));
  }
  EXPECT_GT(cost[0], 1.0);  // the even one is off by more than the noise
  EXPECT_LT(cost[1], 0.5 * cost[0]);
}

}  // namespace
}  // namespace tenter::estimation
