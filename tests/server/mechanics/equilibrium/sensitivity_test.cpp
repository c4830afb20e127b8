// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/sensitivity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/model/presets.h"

namespace tenter::mechanics {
namespace {

/// A cloth of 9 x 9 nodes between a prescribed clip and what the test adds.
struct ClothBetween {
  Cloth cloth = cloth_of_grid({9, 9, 0.1, 0.1}, Diagonals::alternating).value();
  model::Model description = model::preset("cloth_stvk").value();
  MeshModel model = MeshModel::make(description, cloth).value();
  Eigen::VectorXd parameters;
  Boundary boundary;
  Loads loads;
  State start;

  ClothBetween() {
    parameters.resize(model.parameter_count());
    parameters << 40.0, 55.0, 8.0, 3e-4, 4e-4, 3.5e-4;
    start.x.resize(3 * model.node_count());
    for (int n = 0; n < model.node_count(); ++n) {
      const Eigen::Vector2d at = cloth.mesh.material_m.col(n);
      start.x.segment<3>(3 * n) << at.x(), at.y(), 2e-3 * std::sin(40.0 * at.x()) * at.y() / 0.1;
    }
    const auto masses = lumped_masses_kg(cloth.mesh, 0.2);
    loads.node_mass_kg =
        Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  }

  std::vector<int> row(int j) const {
    std::vector<int> nodes;
    for (int i = 0; i < 9; ++i) nodes.push_back(9 * j + i);
    return nodes;
  }
  void add_clip(const std::string& id, int row_of_nodes) {
    Pose pose;
    pose.position_m = start.x.segment<3>(3 * static_cast<Eigen::Index>(9 * row_of_nodes + 4));
    boundary.clips.push_back(clip_on(id, row(row_of_nodes), start.x, pose));
    start.clips.push_back(pose);
  }
  /// One that cords pull, beside one that is held.
  void add_free_clip() {
    add_clip("held", 0);
    add_clip("free", 8);
    Clip& free = boundary.clips[1];
    free.is_free = true;
    free.mass_kg = 0.02;
    free.centre_of_mass_m = Eigen::Vector3d(0.0, 0.005, 0.0);
    free.cord_place_m = {{-0.04, 0.01, 0.0}, {0.045, 0.01, 0.0}};
    loads.cord_force_N = {{}, {{-0.05, 0.8, 0.05}, {0.1, 0.9, 0.0}}};
  }
};

EquilibriumOptions to_rounding() {
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  return options;
}

struct Solved {
  State state;
  EquilibriumResult result;
};

Solved solve(EquilibriumSolver& solver, const ClothBetween& setup,
             const Eigen::VectorXd& parameters, const State& start,
             const EquilibriumOptions& options) {
  Solved solved{start, {}};
  auto result = solver.solve(parameters, setup.loads, solved.state, options);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  if (result) {
    EXPECT_TRUE(result->is_good(options)) << describe(*result, options);
    solved.result = *result;
  }
  return solved;
}

EquilibriumOptions near(EquilibriumOptions options) {
  options.start_is_near = true;
  return options;
}

/// dx/dp, reactions and an objective's gradient beside central differences of whole solves.
void compare_with_differences(ClothBetween& setup, std::vector<Obstacle> obstacles,
                              const EquilibriumOptions& options, double tolerance) {
  auto solver = EquilibriumSolver::make(setup.model, setup.boundary, std::move(obstacles)).value();
  const Solved at = solve(solver, setup, setup.parameters, setup.start, options);
  const auto change = sensitivity_by_parameter(solver, setup.parameters, at.state);
  ASSERT_TRUE(change) << change.error().message;

  const Eigen::VectorXd by_x = Eigen::VectorXd::LinSpaced(at.state.x.size(), -1.0, 2.0);
  const Eigen::VectorXd by_gradient = Eigen::VectorXd::LinSpaced(at.state.x.size(), 3.0, -0.5);
  const auto adjoint =
      objective_by_parameter(solver, setup.parameters, at.state, by_x, by_gradient);
  ASSERT_TRUE(adjoint) << adjoint.error().message;
  const auto objective = [&](const Solved& s) {
    Eigen::VectorXd gradient = s.result.by_node;
    for (const int node : solver.unknowns().free_nodes())
      gradient.segment<3>(3 * static_cast<Eigen::Index>(node)).setZero();
    return by_x.dot(s.state.x) + by_gradient.dot(gradient);
  };

  double moved_in_all = 0.0;
  for (int p = 0; p < setup.model.parameter_count(); ++p) {
    const double h = 1e-4 * setup.parameters[p];
    Eigen::VectorXd up = setup.parameters, down = setup.parameters;
    up[p] += h;
    down[p] -= h;
    const Solved high = solve(solver, setup, up, at.state, near(options));
    const Solved low = solve(solver, setup, down, at.state, near(options));
    const Eigen::VectorXd dx = (high.state.x - low.state.x) / (2.0 * h);
    const double scale = dx.norm();
    moved_in_all += scale * setup.parameters[p];
    EXPECT_LT((change->x.col(p) - dx).norm(), tolerance * scale) << "parameter " << p;
    const double difference = (objective(high) - objective(low)) / (2.0 * h);
    EXPECT_NEAR((*adjoint)[p], difference, tolerance * (scale + std::abs(difference)))
        << "parameter " << p;

    for (const Clip& clip : setup.boundary.clips) {
      const Eigen::Vector3d about(0.03, -0.02, 0.01);
      const Wrench a = reaction(clip, high.state.x, high.result.by_node, about);
      const Wrench b = reaction(clip, low.state.x, low.result.by_node, about);
      const Wrench w = reaction_change(clip, at.state.x, at.result.by_node, *change, p, about);
      const Eigen::Vector3d df = (a.force_N - b.force_N) / (2.0 * h);
      const Eigen::Vector3d dt = (a.torque_N_m - b.torque_N_m) / (2.0 * h);
      const double whole = change->gradient.col(p).norm() + 1e-6 / setup.parameters[p];
      EXPECT_LT((w.force_N - df).norm(), tolerance * whole) << clip.id << ", parameter " << p;
      EXPECT_LT((w.torque_N_m - dt).norm(), tolerance * whole) << clip.id << ", parameter " << p;
    }
  }
  EXPECT_GT(moved_in_all, 1e-3);  // the parameters matter here
}

TEST(Sensitivity, FollowsWholeSolvesWithPrescribedClips) {
  ClothBetween setup;
  setup.add_clip("lower", 0);
  setup.add_clip("upper", 8);
  setup.start.clips[1].position_m += Eigen::Vector3d(0.01, 0.006, 0.003);
  setup.start.clips[1].rotation = rotation_of({0.05, 0.02, -0.04});
  compare_with_differences(setup, {}, to_rounding(), 1e-5);
}

TEST(Sensitivity, FollowsWholeSolvesWithAFreeClip) {
  ClothBetween setup;
  setup.add_free_clip();
  compare_with_differences(setup, {}, to_rounding(), 1e-5);
}

TEST(Sensitivity, FollowsWholeSolvesInContact) {
  ClothBetween setup;
  setup.boundary.held = setup.row(8);
  const Plane plane{Eigen::Vector3d(0.0, 0.0, -0.02), Eigen::Vector3d::UnitZ()};
  EquilibriumOptions options;
  options.tolerance_N = 1e-11;
  options.contact_depth_m = 1e-12;
  compare_with_differences(setup, {plane}, options, 1e-4);
}

TEST(Sensitivity, ByDisplacementOfWhatIsHeld) {
  ClothBetween setup;
  setup.add_clip("lower", 0);
  setup.boundary.held = {9 * 8 + 1, 9 * 8 + 6};
  for (const int node : setup.boundary.held)
    setup.start.x.segment<3>(3 * node) += Eigen::Vector3d(0.002, 0.008, 0.001);
  auto solver = EquilibriumSolver::make(setup.model, setup.boundary).value();
  const Solved at = solve(solver, setup, setup.parameters, setup.start, to_rounding());
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(at.state.x.size(), 1);
  held.col(0).segment<3>(3 * (9 * 8 + 1)) = Eigen::Vector3d(0.3, -0.4, 0.9);
  held.col(0).segment<3>(3 * (9 * 8 + 6)) = Eigen::Vector3d(-0.5, 0.6, 0.2);
  const auto change = sensitivity_by_displacement(solver, setup.parameters, at.state, held);
  ASSERT_TRUE(change) << change.error().message;
  const double h = 1e-5;
  State up = at.state, down = at.state;
  up.x += h * held.col(0);
  down.x -= h * held.col(0);
  const Solved high = solve(solver, setup, setup.parameters, up, near(to_rounding()));
  const Solved low = solve(solver, setup, setup.parameters, down, near(to_rounding()));
  const Eigen::VectorXd dx = (high.state.x - low.state.x) / (2.0 * h);
  EXPECT_GT(dx.norm(), 1.0);
  EXPECT_LT((change->x.col(0) - dx).norm(), 1e-5 * dx.norm());
  for (const int node : setup.boundary.held) {
    const Eigen::Vector3d df =
        (high.result.by_node - low.result.by_node).segment<3>(3 * node) / (2.0 * h);
    EXPECT_LT((change->gradient.col(0).segment<3>(3 * node) - df).norm(), 1e-5 * df.norm());
  }
}

/// A factor on the weight of the sheet, of which a part hangs in a free clip, and columns of
/// parameters and of outer changes together.
TEST(Sensitivity, ByLoad) {
  ClothBetween setup;
  setup.add_free_clip();
  auto solver = EquilibriumSolver::make(setup.model, setup.boundary).value();
  const Solved at = solve(solver, setup, setup.parameters, setup.start, to_rounding());
  OuterChange outer;
  outer.load_N.resize(at.state.x.size(), 1);
  for (Eigen::Index i = 0; i < setup.loads.node_mass_kg.size(); ++i)
    outer.load_N.col(0).segment<3>(3 * i) = -setup.loads.node_mass_kg[i] * setup.loads.gravity_m_s2;
  const auto change = sensitivity_by_load(solver, setup.parameters, at.state, outer.load_N);
  ASSERT_TRUE(change) << change.error().message;
  const std::vector<Eigen::Index> some = {2, 0};
  const auto all = sensitivity_by_parameter(solver, setup.parameters, at.state);
  const auto both = sensitivity_by_parameter(solver, setup.parameters, at.state, &some, &outer);
  ASSERT_TRUE(all && both);
  ASSERT_EQ(both->x.cols(), 3);
  EXPECT_LT((both->x.col(0) - all->x.col(2)).norm(), 1e-12 * all->x.col(2).norm());
  EXPECT_LT((both->x.col(2) - change->x.col(0)).norm(), 1e-12 * change->x.col(0).norm());
  EXPECT_LT((both->gradient.col(2) - change->gradient.col(0)).norm(),
            1e-12 * change->gradient.col(0).norm());

  const double h = 1e-4;
  const Eigen::VectorXd masses = setup.loads.node_mass_kg;
  setup.loads.node_mass_kg = (1.0 + h) * masses;
  const Solved high = solve(solver, setup, setup.parameters, at.state, near(to_rounding()));
  setup.loads.node_mass_kg = (1.0 - h) * masses;
  const Solved low = solve(solver, setup, setup.parameters, at.state, near(to_rounding()));
  const Eigen::VectorXd dx = (high.state.x - low.state.x) / (2.0 * h);
  EXPECT_GT(dx.norm(), 1e-4);
  EXPECT_LT((change->x.col(0) - dx).norm(), 1e-5 * dx.norm());
  for (const int node : setup.boundary.clips[0].nodes) {
    const Eigen::Vector3d df =
        (high.result.by_node - low.result.by_node).segment<3>(3 * node) / (2.0 * h);
    EXPECT_GT(df.norm(), 1e-5);
    EXPECT_LT((change->gradient.col(0).segment<3>(3 * node) - df).norm(), 1e-5 * df.norm());
  }
}

/// After a small change of parameters one factorisation serves the solve and its derivatives, which
/// are off by what the stiffness changed on the way.
TEST(Sensitivity, OneFactorServesASolveAndItsDerivatives) {
  ClothBetween setup;
  setup.add_clip("lower", 0);
  setup.add_clip("upper", 8);
  setup.start.clips[1].position_m += Eigen::Vector3d(0.01, 0.006, 0.003);
  auto solver = EquilibriumSolver::make(setup.model, setup.boundary).value();
  EquilibriumOptions options = to_rounding();
  const Solved at = solve(solver, setup, setup.parameters, setup.start, options);
  options = near(options);
  options.tolerance_N = 1e-9;
  options.predict = false;
  double far = 0.0;
  for (const double part : {1e-2, 1e-3}) {
    const Eigen::VectorXd parameters = (1.0 + part) * setup.parameters;
    EquilibriumOptions frugal = options;
    frugal.reuse_factor = true;
    const Solved cheap = solve(solver, setup, parameters, at.state, frugal);
    EXPECT_EQ(cheap.result.factorisations, 1);
    const auto roughly = sensitivity_by_parameter(solver, parameters, cheap.state);
    ASSERT_TRUE(roughly) << roughly.error().message;
    const Solved dear = solve(solver, setup, parameters, at.state, options);
    EXPECT_GT(dear.result.factorisations, 1);
    const auto exactly = sensitivity_by_parameter(solver, parameters, dear.state);
    ASSERT_TRUE(exactly) << exactly.error().message;
    EXPECT_LT((cheap.state.x - dear.state.x).norm(), 1e-3 * (dear.state.x - at.state.x).norm());
    const double off = (roughly->x - exactly->x).norm() / exactly->x.norm();
    EXPECT_LT(off, 10.0 * part);
    if (far > 0.0) {
      EXPECT_LT(off, 0.2 * far);  // in proportion to the way
    }
    far = off;
  }
  EXPECT_GT(far, 0.0);
}

TEST(Sensitivity, IsRefusedWithoutAStableEquilibrium) {
  ClothBetween setup;
  setup.boundary.held = setup.row(0);
  auto solver = EquilibriumSolver::make(setup.model, setup.boundary).value();
  const auto change = sensitivity_by_parameter(solver, setup.parameters, setup.start);
  ASSERT_FALSE(change);
  EXPECT_EQ(change.error().kind, ErrorKind::refused);
}

}  // namespace
}  // namespace tenter::mechanics
