// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "server/estimation/convexity/nearest_point.h"
#include "server/estimation/prediction.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/convexity.h"
#include "server/mechanics/mesh/grid.h"

namespace tenter::estimation {
namespace {

// Against the conditions of optimality: rows hold, multipliers are not negative, and only rows that
// are met with equality have one.
TEST(NearestPoint, MeetsTheConditionsOfOptimality) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int at_an_edge = 0;
  for (int sample = 0; sample < 50; ++sample) {
    const Eigen::Index n = 2 + sample % 7;
    const Eigen::Index m = 3 + sample % 11;
    const auto filled = [&](Eigen::Index r, Eigen::Index c) {
      return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(r, c, [&] { return normal(random); }));
    };
    const Eigen::MatrixXd root = filled(n, n);
    const Eigen::MatrixXd metric = root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd rows = filled(m, n);
    rows.row(m - 1) = rows.row(0);  // twice
    const Eigen::VectorXd inside = filled(n, 1);
    Eigen::VectorXd least = rows * inside;
    least.array() -= 0.3;
    const Eigen::VectorXd x0 = 4.0 * filled(n, 1);
    const auto x = nearest_point(x0, metric, rows, least);
    ASSERT_TRUE(x) << sample;
    const Eigen::VectorXd gap = rows * *x - least;
    EXPECT_GT(gap.minCoeff(), -1e-8 * x0.norm()) << sample;
    std::vector<Eigen::Index> active;
    for (Eigen::Index i = 0; i + 1 < m; ++i)
      if (gap[i] < 1e-7 * x0.norm()) active.push_back(i);
    if (active.empty()) {
      EXPECT_LT((*x - x0).norm(), 1e-12);
      continue;
    }
    ++at_an_edge;
    const Eigen::MatrixXd edges = rows(active, Eigen::all);
    const Eigen::VectorXd pull = metric * (*x - x0);
    const Eigen::VectorXd u = edges.transpose().colPivHouseholderQr().solve(pull);
    EXPECT_LT((edges.transpose() * u - pull).norm(), 1e-7 * pull.norm()) << sample;
    EXPECT_GT(u.minCoeff(), -1e-7 * u.cwiseAbs().maxCoeff()) << sample;
  }
  EXPECT_GT(at_an_edge, 30);
  Eigen::MatrixXd against(2, 1);
  against << 1.0, -1.0;
  EXPECT_FALSE(nearest_point(Eigen::VectorXd::Zero(1), {}, against, Eigen::Vector2d(1.0, 1.0)));
}

/// Thesis (4.3): k of weft and warp lambda + 2 mu, coupling lambda, shear mu.
model::Model stvk(double lambda, double mu) {
  model::Model model = model::preset("stvk_orthotropic").value();
  for (model::Term& term : model.terms) {
    double& value = term.law.parameters[0].value;
    value = term.id == "coupling" ? lambda : term.id == "shear" ? mu : lambda + 2.0 * mu;
  }
  return model;
}

/// One triangle let go from an equal stretch, moved down its energy in small steps: its farthest
/// corner from rest (m), and the least energy met (J).
struct Motion {
  double farthest_m = 0.0;
  double least_J = 0.0;
};
Motion let_go(const model::Model& model) {
  const auto cloth = cloth_of_grid({2, 2, 0.01, 0.01}, mechanics::Diagonals::alternating).value();
  const auto bound = mechanics::MeshModel::make(model, cloth).value();
  const Eigen::VectorXd p = mechanics::term_parameters(model);
  Eigen::VectorXd rest(3 * bound.node_count());
  for (int n = 0; n < bound.node_count(); ++n)
    rest.segment<3>(3 * static_cast<Eigen::Index>(n)) << cloth.mesh.material_m(0, n),
        cloth.mesh.material_m(1, n), 0.0;
  Eigen::VectorXd x = 1.02 * rest;
  Eigen::VectorXd gradient;
  Motion motion;
  for (int step = 0; step < 400; ++step) {
    double energy = 0.0;
    EXPECT_EQ(bound.evaluate(x, p, {&energy, &gradient}), mechanics::AssemblyStatus::ok);
    x -= 2e-3 * gradient;
    motion.least_J = std::min(motion.least_J, energy);
    Eigen::VectorXd off = x - rest;
    for (int n = 1; n < bound.node_count(); ++n)  // apart from a common shift
      off.segment<3>(3 * static_cast<Eigen::Index>(n)) -= off.head<3>();
    off.head<3>().setZero();
    motion.farthest_m = off.cwiseAbs().maxCoeff();
    if (motion.farthest_m > 0.005) break;
  }
  return motion;
}

// Fig. 4.2: a large negative lambda drives cloth away from rest; its projection brings it back.
TEST(ConvexProjection, MendsALargeNegativeLambda) {
  model::Model model = stvk(-70.0, 40.0);
  const Motion before = let_go(model);
  EXPECT_GT(before.farthest_m, 0.004);
  EXPECT_LT(before.least_J, -1e-8);
  const auto constraints = ConvexityConstraints::make(model);
  ASSERT_TRUE(constraints) << constraints.error().message;
  EXPECT_GT(constraints->matrix_count(), 50);
  const auto worst = constraints->worst(parameter_values(model));
  EXPECT_EQ(model.terms[static_cast<std::size_t>(worst.term)].id, "coupling");
  EXPECT_NEAR(worst.smallest, 10.0 - 70.0, 1e-9);
  const ConvexProjection mended = project_onto_convex(*constraints, parameter_values(model));
  ASSERT_EQ(mended.status, ConvexStatus::ok);
  // in closed form: min 2 (a - 10)^2 + (c + 70)^2 with a = -c gives a = 30
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i]->value = mended.parameters[static_cast<Eigen::Index>(i)];
  EXPECT_NEAR(mended.parameters[0], 30.0, 1e-6);
  EXPECT_NEAR(mended.parameters[1], 30.0, 1e-6);
  EXPECT_NEAR(mended.parameters[2], -30.0, 1e-6);
  EXPECT_EQ(mended.parameters[3], 40.0);
  EXPECT_GT(constraints->worst(mended.parameters).relative, -1e-8);
  // a little inside, so that the stretch has a way back
  parameters[2]->value *= 0.9;
  const Motion after = let_go(model);
  EXPECT_LT(after.farthest_m, 2e-4);
  EXPECT_EQ(after.least_J, 0.0);
}

// Random energies with splines and a surface of Gaussians become convex on samples that the
// projection did not use, and convex ones stay what they are.
TEST(ConvexProjection, MakesSplinesAndSurfacesConvex) {
  model::Model model = stvk(20.0, 30.0);
  model.terms[0].law = {};
  model.terms[0].law.name = "hermite_energy";
  model.terms[0].law.range_lo = -0.1;
  model.terms[0].law.range_hi = 0.3;
  model.terms[0].law.parameters = default_parameters(*model::find_law("hermite_energy"), 7);
  model.terms[2].law.name = "gaussian_energy_2";
  model.terms[2].law.range_lo = -0.1;
  model.terms[2].law.range_hi = 0.3;
  model.terms[2].law.parameters = default_parameters(*model::find_law("gaussian_energy_2"), 9);
  const auto constraints = ConvexityConstraints::make(model).value();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  Eigen::VectorXd p = parameter_values(model);
  for (int i = 0; i < 7; ++i) {
    const double eps = -0.1 + 0.4 * i / 6.0;
    p[i] = 60.0 * eps * eps + 0.8 * normal(random);
  }
  for (Eigen::Index i = 8; i < 17; ++i) p[i] = 1.5 * normal(random);
  EXPECT_LT(constraints.worst(p).relative, -0.05);
  for (const bool has_metric : {false, true}) {
    Eigen::MatrixXd metric;
    if (has_metric) {
      const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(p.size(), 1.0, 5.0);
      metric = weights.asDiagonal();
    }
    const ConvexProjection mended = project_onto_convex(constraints, p, metric);
    ASSERT_EQ(mended.status, ConvexStatus::ok);
    EXPECT_GT((mended.parameters - p).norm(), 0.1);
    EXPECT_GT(constraints.worst(mended.parameters).relative, -1e-7);
    const auto finer = ConvexityConstraints::make(model, {.samples = 101, .samples_of_two = 31});
    EXPECT_GT(finer->worst(mended.parameters).relative, -0.02);
    EXPECT_LT(finer->worst(p).relative, -0.05);
    const ConvexProjection again = project_onto_convex(constraints, mended.parameters, metric);
    EXPECT_EQ(again.rounds, 0);
    // a one-strain addend by the check of mechanics, which knows no samples of ours
    const auto law = mechanics::make_law(model.terms[0].law, 1).value();
    const auto convexity = mechanics::law_convexity(*law, mended.parameters.data(), -0.1, 0.3, 997);
    EXPECT_GT(convexity.smallest, -1e-6 * convexity.largest);
    EXPECT_GT(convexity.largest, 10.0);
  }
}

TEST(ConvexProjection, FixedParametersStayAndMayMakeItImpossible) {
  model::Model model = stvk(-70.0, 40.0);
  model.terms[2].law.parameters[0].fixed = true;
  auto constraints = ConvexityConstraints::make(model).value();
  const auto mended = project_onto_convex(constraints, parameter_values(model));
  ASSERT_EQ(mended.status, ConvexStatus::ok);
  EXPECT_EQ(mended.parameters[2], -70.0);
  EXPECT_NEAR(mended.parameters[0], 70.0, 1e-6);
  model.terms[0].law.parameters[0].upper = 20.0;
  model.terms[1].law.parameters[0].upper = 20.0;
  constraints = ConvexityConstraints::make(model).value();
  EXPECT_NE(project_onto_convex(constraints, parameter_values(model)).status, ConvexStatus::ok);
}

// The Hessian in the strains of a coupling is that of the energy, for measures that are not linear
// in the tensor too: soft constraints with a coupling, where k_u k_v >= c^2 is the answer.
TEST(ConvexProjection, HessiansAreInTheCouplingsOwnStrains) {
  model::Model model = model::preset("soft_constraints").value();
  model::Term coupling;
  coupling.id = "coupling";
  coupling.strain.name = "soft_pair";
  coupling.law.name = "bilinear";
  coupling.law.parameters = model::default_parameters(*model::find_law("bilinear"));
  model.terms.push_back(coupling);
  Eigen::VectorXd p = parameter_values(model);
  const auto constraints = ConvexityConstraints::make(model).value();
  p << 50.0, 18.0, 9.0, 30.0 - 1e-6;  // 30^2 = 50 * 18
  EXPECT_GT(constraints.worst(p).smallest, 0.0);
  p[3] = 30.0 + 1e-6;
  EXPECT_LT(constraints.worst(p).smallest, 0.0);
  p[3] = 60.0;
  EXPECT_NEAR(constraints.worst(p).smallest, 34.0 - std::hypot(16.0, 60.0), 1e-9);
}

}  // namespace
}  // namespace tenter::estimation
