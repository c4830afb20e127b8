// SPDX-License-Identifier: GPL-3.0-or-later
// The models behind the tables: variants of Appendix A, the progression of Table 4.1, residuals.
#include <gtest/gtest.h>

#include <cmath>

#include "common/model/document.h"
#include "common/model/presets.h"
#include "server/estimation/staged/tables/progressive.h"
#include "server/estimation/staged/tables/variants.h"
#include "tests/server/estimation/staged/small_rig.h"

namespace tenter::estimation {
namespace {

TEST(Variants, AreTwelveModelsThatShareWhatTheyShould) {
  const auto variants = all_variants();
  ASSERT_EQ(variants.size(), 12U);
  EXPECT_EQ(words_of(variants.front()), "Non-Linear Ortho.");
  EXPECT_EQ(words_of(variants.back()), "Linear Iso.");
  for (const Variant& variant : variants) {
    const VariantModel form = variant_model(variant);
    EXPECT_TRUE(model::validate(form.model));
    const auto ties = tie_terms(form.model, form.ties);
    ASSERT_TRUE(ties) << ties.error().message;
    const int curves = variant.is_isotropic ? 4 : 6;
    EXPECT_EQ(ties->map.cols(), variant.is_nonlinear ? 5 * curves : curves);
    EXPECT_EQ(ties->map.rowwise().sum().minCoeff(), 1.0);
  }
}

TEST(ScenarioResidual, IsTheNoiseOfTheTruthAndGrowsWithError) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.frames = 10;
  for (const Role role : {Role::stretch_u, Role::shear, Role::bend_u, Role::evaluation}) {
    const RoleSequence measured = measured_in_rig(role, truth, rig);
    const auto at_truth = scenario_residual(truth, measured);
    ASSERT_TRUE(at_truth) << at_truth.error().message;
    EXPECT_EQ(at_truth->restless, 0);
    EXPECT_NEAR(at_truth->position_mm, 1e3 * std::sqrt(3.0) * rig.point_sigma_m, 0.005);
    if (role == Role::bend_u)
      EXPECT_EQ(at_truth->force_rows, 0);
    else
      EXPECT_NEAR(at_truth->force_N, rig.force_sigma_N, 0.5 * rig.force_sigma_N);
    if (role == Role::shear) {
      EXPECT_EQ(at_truth->force_rows, 10);  // those along the clip
    }
    model::Model wrong = truth;
    for (model::Parameter* p : parameters_of(wrong)) p->value *= 2.0;
    const auto off = scenario_residual(wrong, measured);
    ASSERT_TRUE(off) << off.error().message;
    if (role != Role::bend_u) {
      EXPECT_GT(off->force_N, 5.0 * at_truth->force_N);
    }
    if (role == Role::bend_u) {
      EXPECT_GT(off->position_mm, 3.0 * at_truth->position_mm);
    }
  }
}

TEST(Progressive, EveryStepBeginsAsTheOneBefore) {
  ProgressiveRanges ranges;
  ProgressiveModel before = progressive_model(0, ranges, nullptr);
  before.ties.free[0].value = 60.0;  // lambda + mu
  before.ties.free[1].value = 25.0;  // mu
  const auto cloth = cloth_of_grid({5, 5, 0.1, 0.1}, mechanics::Diagonals::alternating).value();
  Eigen::VectorXd x(3 * cloth.mesh.node_count());
  for (int n = 0; n < cloth.mesh.node_count(); ++n) {
    const double u = cloth.mesh.material_m(0, n);
    const double v = cloth.mesh.material_m(1, n);
    x.segment<3>(3 * static_cast<Eigen::Index>(n)) << 1.05 * u + 0.1 * v, 1.02 * v + 0.3 * u * v,
        0.05 * u * u;
  }
  Eigen::VectorXd gradient, next;
  const auto forces = [&](const ProgressiveModel& m, Eigen::VectorXd& out) {
    double energy = 0.0;
    const auto bound = mechanics::MeshModel::make(m.model, cloth).value();
    ASSERT_EQ(bound.evaluate(x, m.ties.all(m.ties.values()), {&energy, &out}),
              mechanics::AssemblyStatus::ok);
  };
  forces(before, gradient);
  EXPECT_GT(gradient.norm(), 0.1);
  for (int step = 1; step < kProgressiveSteps; ++step) {
    const ProgressiveModel now = progressive_model(step, ranges, &before);
    EXPECT_TRUE(model::validate(now.model)) << step;
    forces(now, next);
    EXPECT_LT((next - gradient).norm(), 1e-12 * gradient.norm()) << now.name;
    EXPECT_GE(now.ties.free.size(), before.ties.free.size()) << now.name;
    before = now;
    // away from the special case, so that the next step has to keep what this one found
    for (std::size_t k = 0; k < before.ties.free.size(); ++k)
      before.ties.free[k].value =
          1.1 * before.ties.free[k].value + (before.ties.free[k].name == "a_weft" ? 7.0 : 0.0);
    forces(before, gradient);
  }
}

TEST(Progressive, ErrorFallsWithEveryAddend) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.nodes = 5;
  rig.frames = 3;
  std::vector<RoleSequence> training = measured_in_rig(truth, rig);
  training.erase(training.begin() + 4);  // bend_v
  const std::vector<RoleSequence> held_out = {measured_in_rig(Role::evaluation, truth, rig)};
  StageOptions options;
  options.weighting.rule = WeightingRule::by_noise;
  const auto rows = progressive_fit(training, held_out, options);
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), static_cast<std::size_t>(kProgressiveSteps));
  for (std::size_t k = 1; k < rows->size(); ++k)
    EXPECT_LT((*rows)[k].cost, (*rows)[k - 1].cost * 1.001) << (*rows)[k].name;
  // the truth has two curves in stretch and one in shear
  EXPECT_LT((*rows)[3].training.force_N, 0.2 * (*rows)[0].training.force_N);
  EXPECT_LT((*rows)[3].held_out.force_N, 0.5 * (*rows)[0].held_out.force_N);
}

}  // namespace
}  // namespace tenter::estimation
