// SPDX-License-Identifier: GPL-3.0-or-later
// Energy constraints of thesis (4.5) in statics.
#include <gtest/gtest.h>

#include "common/model/presets.h"
#include "server/mechanics/equilibrium/equilibrium.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::mechanics {
namespace {

constexpr double kStiffness_N_m = 40.0;
constexpr double kWidth_m = 0.05;
constexpr double kLength_m = 0.1;

/// A strip whose warp may hold only so much energy per area.
model::Model limited_model(double energy_max) {
  model::Model model = model::preset("cloth_soft").value();
  for (model::Term& term : model.terms)
    if (term.strain.name == "soft_v") {
      term.law.parameters[0].value = kStiffness_N_m;
      model::EnergyLimit limit;
      limit.id = "warp";
      limit.terms = {term.id};
      limit.energy_max = energy_max;
      limit.unit = "J/m^2";
      model.limits = {limit};
    }
  return model;
}

struct Strip {
  Grid grid{4, 7, kWidth_m, kLength_m};
  Cloth cloth = cloth_of_grid(grid, Diagonals::alternating).value();
  Boundary boundary;
  Loads loads;
  State state;

  /// Held at the bottom, with a bar at the top that a cord pulls up with `force_N`.
  explicit Strip(double force_N) {
    state.x.resize(3 * grid.node_count());
    for (int n = 0; n < grid.node_count(); ++n)
      state.x.segment<3>(3 * static_cast<Eigen::Index>(n)) << cloth.mesh.material_m(0, n),
          cloth.mesh.material_m(1, n), 0.0;
    std::vector<int> top;
    for (int i = 0; i < grid.nodes_u; ++i) {
      boundary.held.push_back(grid.node(i, 0));
      top.push_back(grid.node(i, grid.nodes_v - 1));
    }
    Pose pose;
    pose.position_m = Eigen::Vector3d(0.5 * kWidth_m, kLength_m, 0.0);
    Clip bar = clip_on("bar", top, state.x, pose);
    bar.is_free = true;
    bar.cord_place_m = {{0.0, 0.01, 0.0}};
    boundary.clips = {bar};
    state.clips = {pose};
    loads.gravity_m_s2.setZero();
    loads.cord_force_N = {{Eigen::Vector3d(0.0, force_N, 0.0)}};
  }
};

/// Warp and weft of soft constraints do not feel each other, so the strip stays a rectangle:
/// F/w = (1 + l) k (stretch - 1), and the limit is (stretch - 1)^2 k/2 = psi_max.
TEST(EnergyLimits, AStripIsHeldAtItsLimitAndTheMultiplierCarriesTheRest) {
  const double strain_max = 0.05;
  const double energy_max = 0.5 * kStiffness_N_m * strain_max * strain_max;
  const model::Model description = limited_model(energy_max);
  const double force_N = 3.0 * kStiffness_N_m * strain_max * kWidth_m;  // thrice what is allowed
  Strip strip(force_N);
  const MeshModel model = MeshModel::make(description, strip.cloth).value();
  auto solver = EquilibriumSolver::make(model, strip.boundary).value();
  EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  const Eigen::VectorXd parameters = term_parameters(description);
  const auto result = solver.solve(parameters, strip.loads, strip.state, options);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->is_good(options)) << describe(*result, options);

  const double stretch = (strip.state.clips[0].position_m.y()) / kLength_m;
  EXPECT_NEAR(stretch - 1.0, strain_max, 1e-6 * strain_max);
  Eigen::VectorXd excess;
  ASSERT_EQ(model.limit_excess(strip.state.x, parameters, excess), AssemblyStatus::ok);
  EXPECT_LE(excess.maxCoeff(), 1e-6 * energy_max);
  ASSERT_EQ(result->limit_multiplier.size(), model.limited_count());
  EXPECT_GT(model.limited_count(), 10);
  for (const double l : result->limit_multiplier) EXPECT_NEAR(l, 2.0, 1e-4);
}

/// A strip pulled askew: elements near one edge are at their limit, others are not. How it answers
/// to parameters and to its held end, beside differences of whole solves.
TEST(EnergyLimits, SensitivitiesFollowWholeSolvesWhereTheyAreActive) {
  const double strain_max = 0.05;
  const model::Model description = limited_model(0.5 * kStiffness_N_m * strain_max * strain_max);
  Strip strip(0.12);
  strip.loads.cord_force_N[0][0] += Eigen::Vector3d(0.03, 0.0, 0.004);
  strip.boundary.clips[0].cord_place_m[0].x() = 0.01;
  const MeshModel model = MeshModel::make(description, strip.cloth).value();
  auto solver = EquilibriumSolver::make(model, strip.boundary).value();
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  options.limit_tolerance = 1e-10;
  const Eigen::VectorXd parameters = term_parameters(description);
  const auto solve = [&](const Eigen::VectorXd& p, State& state, Eigen::VectorXd& gradient) {
    const auto result = solver.solve(p, strip.loads, state, options);
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_TRUE(result->is_good(options)) << describe(*result, options);
    gradient = result->by_node;
    for (const int node : solver.unknowns().free_nodes())
      gradient.segment<3>(3 * static_cast<Eigen::Index>(node)).setZero();
  };
  State at = strip.state;
  Eigen::VectorXd gradient;
  solve(parameters, at, gradient);
  ActiveLimits active;
  ASSERT_EQ(model.active_limits(at.x, parameters, solver.limits(), active), AssemblyStatus::ok);
  EXPECT_GT(active.entry.size(), 3u);
  EXPECT_LT(active.entry.size(), static_cast<std::size_t>(model.limited_count()) - 3u);
  const auto change = sensitivity_by_parameter(solver, parameters, at);
  ASSERT_TRUE(change) << change.error().message;
  const Eigen::VectorXd by_x = Eigen::VectorXd::LinSpaced(at.x.size(), -1.0, 2.0);
  const Eigen::VectorXd by_gradient = Eigen::VectorXd::LinSpaced(at.x.size(), 3.0, -0.5);
  const auto adjoint = objective_by_parameter(solver, parameters, at, by_x, by_gradient);
  ASSERT_TRUE(adjoint) << adjoint.error().message;
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(at.x.size(), 1);
  held.col(0).segment<3>(3 * strip.boundary.held[1]) << 0.2, 0.4, -0.3;
  const auto by_held = sensitivity_by_displacement(solver, parameters, at, held);
  ASSERT_TRUE(by_held) << by_held.error().message;

  int felt = 0;
  State high = at, low = at;
  Eigen::VectorXd high_gradient, low_gradient;
  const auto compare = [&](double h, const Eigen::VectorXd& x, const Eigen::VectorXd& g,
                           const std::string& what) {
    const Eigen::VectorXd dx = (high.x - low.x) / (2.0 * h);
    const Eigen::VectorXd dg = (high_gradient - low_gradient) / (2.0 * h);
    EXPECT_LT((x - dx).norm(), 1e-5 * dx.norm() + 1e-12 / h) << what;
    EXPECT_LT((g - dg).norm(), 1e-5 * dg.norm() + 1e-12 / h) << what;
    felt += dx.norm() * h > 1e-8;
  };
  for (int p = 0; p < model.parameter_count(); ++p) {
    const double h = 1e-4 * parameters[p];
    Eigen::VectorXd up = parameters, down = parameters;
    up[p] += h;
    down[p] -= h;
    high = low = at;
    solve(up, high, high_gradient);
    solve(down, low, low_gradient);
    compare(h, change->x.col(p), change->gradient.col(p), "parameter " + std::to_string(p));
    const double difference =
        (by_x.dot(high.x - low.x) + by_gradient.dot(high_gradient - low_gradient)) / (2.0 * h);
    EXPECT_NEAR((*adjoint)[p], difference, 1e-5 * std::abs(difference) + 1e-10 / h) << p;
  }
  EXPECT_GT(felt, 2);
  const double h = 1e-6;
  high = low = at;
  high.x += h * held.col(0);
  low.x -= h * held.col(0);
  solve(parameters, high, high_gradient);
  solve(parameters, low, low_gradient);
  compare(h, by_held->x.col(0), by_held->gradient.col(0), "held node");
}

TEST(EnergyLimits, AreSilentWhereTheyAreNotReached) {
  const model::Model limited = limited_model(1.0);
  model::Model free = limited;
  free.limits.clear();
  Strip a(0.1), b(0.1);
  const MeshModel with = MeshModel::make(limited, a.cloth).value();
  const MeshModel without = MeshModel::make(free, b.cloth).value();
  const Eigen::VectorXd parameters = term_parameters(limited);
  auto first = EquilibriumSolver::make(with, a.boundary).value();
  auto second = EquilibriumSolver::make(without, b.boundary).value();
  const EquilibriumOptions options;
  const auto one = first.solve(parameters, a.loads, a.state, options);
  const auto two = second.solve(parameters, b.loads, b.state, options);
  ASSERT_TRUE(one && two);
  EXPECT_TRUE(one->is_good(options) && two->is_good(options));
  EXPECT_EQ(one->limit_multiplier.maxCoeff(), 0.0);
  EXPECT_EQ(a.state.x, b.state.x);
  EXPECT_GT(a.state.clips[0].position_m.y(), 1.01 * kLength_m);
}

}  // namespace
}  // namespace tenter::mechanics
