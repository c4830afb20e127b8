// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/potential.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <optional>

#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Comparison;
using tenter::testing::difference;
using tenter::testing::Numbers;

constexpr int kSide = 5;
constexpr double kLength = 0.2;
constexpr double kPenalty = 80.0;  // N/m

/// Membrane, hinges and springs at once, of like weight at edges of 5 cm.
model::Model rich_model() {
  model::Model model = preset_with("cloth_stvk", {{"weft", 90.0},
                                                  {"warp", 110.0},
                                                  {"shear", 40.0},
                                                  {"bend_weft", 0.010},
                                                  {"bend_warp", 0.013},
                                                  {"bend_diagonal", 0.017}});
  for (model::Term term : preset_with("cloth_springs", {{"bend_weft", 30.0}}).terms) {
    term.id += "_spring";
    model.terms.push_back(term);
  }
  return model;
}

Eigen::Matrix3d some_turn(Numbers& numbers) {
  const auto angle = [&numbers] { return numbers.between(-0.4, 0.4); };
  const double a = angle(), b = angle(), c = angle();
  return rotation_of({a, b, c});
}

/// Everything that acts on cloth, at a random state.
struct Everything {
  explicit Everything(unsigned seed, bool under_pressure = true)
      : sheet(cloth_of_grid({kSide, kSide, kLength, kLength}, Diagonals::both).value(),
              rich_model()) {
    Numbers numbers(seed);
    state.x = shaken(flat(sheet.cloth.mesh), 0.006, seed);
    boundary.held = {0, 5};
    const Pose there{some_turn(numbers), {0.01, -0.02, 0.03}};
    boundary.clips = {clip_on("prescribed", {4, 9}, state.x, there),
                      clip_on("free", {20, 21, 22, 23}, state.x, there),
                      clip_on("small", {24}, state.x, there)};
    state.clips = {there, there, there};
    for (const int c : {1, 2}) {
      Clip& clip = boundary.clips[static_cast<std::size_t>(c)];
      clip.is_free = true;
      clip.mass_kg = 0.012 * c;
      clip.centre_of_mass_m = clip.place_m[0] + Eigen::Vector3d(0.01, 0.02, -0.015);
      clip.cord_place_m = {clip.place_m[0] + Eigen::Vector3d(0.0, 0.03, 0.01),
                           clip.place_m.back() + Eigen::Vector3d(0.01, 0.02, 0.01)};
    }
    loads = weight(sheet.cloth.mesh, 0.2);
    loads.node_force_N = shaken(Eigen::VectorXd::Zero(3 * sheet.nodes()), 0.05, seed + 1);
    loads.cord_force_N = {{}, {{0.2, 1.1, -0.3}, {-0.4, 0.9, 0.2}}, {{0.1, 0.3, 0.2}, {0, 0, 0.4}}};
    // a pillow of no thickness: one covering is its top, the other its bottom
    for (int t = 0; t < sheet.cloth.mesh.triangle_count(); ++t) {
      const auto [a, b, c] = sheet.cloth.mesh.triangles[static_cast<std::size_t>(t)];
      boundary.pressed.push_back(sheet.cloth.mesh.layer(t) == 0 ? std::array{a, b, c}
                                                                : std::array{a, c, b});
    }
    if (under_pressure) loads.pressure_Pa = 170.0;
    EXPECT_TRUE(check(boundary, sheet.nodes()));
    EXPECT_TRUE(check(loads, boundary, sheet.nodes()));
    unknowns.emplace(boundary, sheet.model.matrix());
    obstacles = {Plane{{0.1, 0.1, 0.0}, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()},
                 Cylinder{{0.1, 0.1, -0.03}, Eigen::Vector3d(1.0, 0.3, 0.1).normalized(), 0.035}};
    contact = Contact(obstacles, unknowns->free_nodes(), kPenalty);
    contact.update_forces(shaken(state.x, 0.004, seed + 2));  // forces of another state
    potential.emplace(sheet.model, sheet.parameters, boundary, *unknowns, loads, contact);
  }

  State moved(const Eigen::VectorXd& step) const {
    State there = state;
    unknowns->move(state, step, 1.0, there);
    return there;
  }

  Sheet sheet;
  Boundary boundary;
  State state;
  Loads loads;
  std::optional<Unknowns> unknowns;
  std::vector<Obstacle> obstacles;
  Contact contact;
  std::optional<Potential> potential;
};

Eigen::MatrixXd dense(const SymmetricPattern& pattern, const std::vector<double>& values) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(pattern.size, pattern.size);
  for (int j = 0; j < pattern.size; ++j)
    for (int k = pattern.column_start[static_cast<std::size_t>(j)];
         k < pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      const int i = pattern.row[static_cast<std::size_t>(k)];
      matrix(i, j) = matrix(j, i) = values[static_cast<std::size_t>(k)];
    }
  return matrix;
}

/// How far every node is from starting or ending to touch (N): differences must not cross that.
double nearest_kink_N(const Everything& all) {
  double nearest = 1e300;
  int touching = 0;
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : all.obstacles) {
    for (const int node : all.unknowns->free_nodes()) {
      const double g = gap(obstacle, all.state.x.segment<3>(3 * node)).value_m;
      const double force = all.contact.force_N()[k++] - kPenalty * g;
      nearest = std::min(nearest, std::abs(force));
      touching += force > 0.0;
    }
  }
  EXPECT_GT(touching, 5);
  EXPECT_LT(touching, static_cast<int>(k) - 5);
  return nearest;
}

TEST(Potential, GradientAndStiffnessAgainstDifferences) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    SCOPED_TRACE(seed);
    const Everything all(seed);
    EXPECT_GT(nearest_kink_N(all), 2e-3);
    PotentialValue value;
    ASSERT_TRUE(all.potential->evaluate_with_stiffness(all.state, 0.0, value));
    const Eigen::MatrixXd stiffness = dense(all.unknowns->pattern(), value.stiffness);
    const int count = all.unknowns->count();
    ASSERT_EQ(count, 3 * (25 - 2 - 2 - 4 - 1) + 12);
    constexpr double kStep = 4e-6;
    Eigen::MatrixXd columns(count, count);
    Comparison gradient("gradient");
    Comparison of_turns("gradient by turns and shifts of clips");
    for (int i = 0; i < count; ++i) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(count, i);
      const auto energy = [&](double by) { return all.potential->energy_J(all.moved(by * unit)); };
      (i < count - 12 ? gradient : of_turns)
          .add(value.by_unknown[i], difference(energy, 0.0, 2.5 * kStep));
      columns.col(i) = difference(
          [&](double by) {
            PotentialValue there;
            EXPECT_TRUE(all.potential->evaluate(all.moved(by * unit), there));
            return there.by_unknown;
          },
          0.0, kStep);
    }
    gradient.judge(1e-6);
    of_turns.judge(1e-6);
    // torques are taken about turned axes, so their differences are symmetric only on the mean
    const Eigen::MatrixXd symmetric = 0.5 * (columns + columns.transpose());
    Comparison second("stiffness"), second_turns("stiffness of turns");
    for (int j = 0; j < count; ++j)
      for (int i = 0; i < count; ++i)
        (std::max(i, j) < count - 12 ? second : second_turns).add(stiffness(i, j), symmetric(i, j));
    second.judge(1e-6);
    second_turns.judge(1e-6);
    // and along straight ways of all unknowns at once, where no choice of axes enters
    Comparison along("second derivative along a way");
    for (unsigned way = 0; way < 8; ++way) {
      Eigen::VectorXd step = shaken(Eigen::VectorXd::Zero(count), 1.0, 40 + way);
      step.tail(12) *= 3.0;
      const auto slope = [&](double by) {
        PotentialValue there;
        EXPECT_TRUE(all.potential->evaluate(all.moved(by * step), there));
        return there.by_unknown.dot(step);
      };
      along.add(step.dot(stiffness * step), difference(slope, 0.0, kStep));
    }
    along.judge(1e-6);
  }
}

TEST(Potential, EnergyAloneIsTheSameEnergy) {
  const Everything all(5);
  PotentialValue value;
  ASSERT_TRUE(all.potential->evaluate(all.state, value));
  EXPECT_GT(std::abs(value.energy_J), 1e-3);
  EXPECT_NEAR(all.potential->energy_J(all.state), value.energy_J, 1e-13 * std::abs(value.energy_J));
}

// The positive share of pressure is not taken: its stiffness has eigenvalues of both signs.
TEST(Potential, ShareOneIsNeverNegative) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    Everything all(seed, false);
    // pushed together: compression is what makes stiffness negative
    for (const int n : all.unknowns->free_nodes()) all.state.x[3 * n] *= 0.6;
    PotentialValue exact, positive;
    ASSERT_TRUE(all.potential->evaluate_with_stiffness(all.state, 0.0, exact));
    ASSERT_TRUE(all.potential->evaluate_with_stiffness(all.state, 1.0, positive));
    const auto lowest = [&](const PotentialValue& value) {
      return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                 dense(all.unknowns->pattern(), value.stiffness))
          .eigenvalues()
          .minCoeff();
    };
    const double scale = dense(all.unknowns->pattern(), exact.stiffness).cwiseAbs().maxCoeff();
    EXPECT_LT(lowest(exact), -1e-6 * scale) << "nothing was left out";
    EXPECT_GT(lowest(positive), -1e-12 * scale);
    EXPECT_EQ(exact.by_unknown, positive.by_unknown);
  }
}

TEST(Potential, PressureInAClosedSurfacePushesNoBody) {
  Everything all(7);
  PotentialValue with, without;
  ASSERT_TRUE(all.potential->evaluate(all.state, with));
  all.loads.pressure_Pa = 0.0;
  ASSERT_TRUE(all.potential->evaluate(all.state, without));
  const Eigen::VectorXd push = with.by_node - without.by_node;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  for (int n = 0; n < all.sheet.nodes(); ++n) {
    const Eigen::Vector3d f = push.segment<3>(3 * n);
    force += f;
    torque += all.state.x.segment<3>(3 * n).cross(f);
  }
  EXPECT_GT(push.norm(), 1e-2);
  EXPECT_LT(force.norm(), 1e-12 * push.norm());
  EXPECT_LT(torque.norm(), 1e-12 * push.norm());
}

TEST(Potential, TheSumOfNodesIsTheMotionOfAClip) {
  const Everything all(6);
  Eigen::VectorXd step = shaken(Eigen::VectorXd::Zero(all.unknowns->count()), 1e-7, 9);
  Eigen::VectorXd by_node;
  all.unknowns->expand(all.state, step, by_node);
  const Eigen::VectorXd moved = all.moved(step).x - all.state.x;
  EXPECT_GT(moved.norm(), 1e-7);
  EXPECT_LT((moved - by_node).norm(), 1e-5 * moved.norm());
}

}  // namespace
}  // namespace tenter::mechanics::testing
