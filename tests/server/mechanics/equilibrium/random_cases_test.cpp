// SPDX-License-Identifier: GPL-3.0-or-later
// Cases nobody thought of: random sheets, stiffnesses over decades, clips, loads, obstacles and
// starts. Whatever happens, the answer is a number and what it says of itself is true.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Numbers;

enum class Support { one_pin, two_pins, edge, clips, free_clip };

class RandomCase {
 public:
  explicit RandomCase(unsigned seed)
      : numbers_(seed * 7919U + 13U), cut_(cloth()), sheet_(cut_, material()) {
    state.x = flat(sheet_.cloth.mesh);
    support_with(static_cast<Support>(pick(5)));
    loads.node_mass_kg = weight(sheet_.cloth.mesh, numbers_.between(0.02, 0.5)).node_mass_kg;
    if (pick(2)) loads.gravity_m_s2 = vector(5.0);
    if (pick(3) == 0) state.x = shaken(state.x, numbers_.between(0.0, 0.3) * grid_.du_m(), seed);
    const double size = grid_.length_u_m;
    if (pick(4) == 0)
      obstacles.emplace_back(
          Plane{{0.0, 0.0, numbers_.between(-0.5, 0.0) * size}, Eigen::Vector3d::UnitZ()});
    if (pick(5) == 0)
      obstacles.emplace_back(
          Cylinder{{0.5 * size, 0.0, -0.3 * size}, Eigen::Vector3d::UnitY(), 0.25 * size});
    options.tolerance_N = pick(3) == 0 ? 0.0 : 1e-5;
    if (pick(6) == 0) options.minimiser = Minimiser::additive_lm;
  }

  const Sheet& sheet() const { return sheet_; }

  Boundary boundary;
  State state;
  Loads loads;
  std::vector<Obstacle> obstacles;
  EquilibriumOptions options;

 private:
  int pick(int count) {
    return std::min(count - 1, static_cast<int>(numbers_.between(0.0, count)));
  }
  Eigen::Vector3d vector(double by) {
    const double x = numbers_.between(-by, by), y = numbers_.between(-by, by);
    return {x, y, numbers_.between(-by, by)};
  }

  Cloth cloth() {
    const int u = 3 + pick(8), v = 3 + pick(8);
    const double side = numbers_.between(0.02, 0.5);
    const double slender = numbers_.between(0.6, 1.6);  // of the cells
    grid_ = {u, v, side, side * slender * (v - 1) / (u - 1)};
    const Diagonals all[] = {Diagonals::one, Diagonals::alternating, Diagonals::other,
                             Diagonals::both};
    return cloth_of_grid(grid_, all[pick(4)]).value();
  }

  /// Membranes from knit to paper, bending from silk to card.
  model::Model material() {
    const char* names[] = {"cloth_springs", "cloth_soft", "cloth_stvk"};
    model::Model model = preset_with(names[pick(3)], {});
    const double membrane = std::pow(10.0, numbers_.between(0.5, 5.0));
    const double bending = model.name == "cloth_springs"
                               ? membrane * numbers_.between(0.0, 0.2)
                               : std::pow(10.0, numbers_.between(-8.0, -3.0));
    for (model::Term& term : model.terms)
      term.law.parameters[0].value =
          numbers_.between(0.3, 2.0) * (term.id.starts_with("bend") ? bending : membrane);
    return model;
  }

  void support_with(Support support) {
    const int last = grid_.nodes_u - 1;
    if (support == Support::one_pin) boundary.held = {0};
    if (support == Support::two_pins) {
      boundary.held = {0, last};
      state.x[3 * static_cast<Eigen::Index>(last)] *= numbers_.between(0.5, 1.2);
    }
    std::vector<int> near, far;
    for (int j = 0; j < grid_.nodes_v; ++j) {
      near.push_back(grid_.node(0, j));
      far.push_back(grid_.node(last, j));
    }
    if (support == Support::edge) boundary.held = near;
    if (support != Support::clips && support != Support::free_clip) return;
    boundary.clips = {clip_on("near", near, state.x, Pose{}), clip_on("far", far, state.x, Pose{})};
    state.clips.resize(2);
    if (support == Support::clips) {
      state.clips[1].position_m = 0.2 * grid_.length_u_m * vector(1.0);
      state.clips[1].rotation = rotation_of(vector(1.5));
      return;
    }
    Clip& bar = boundary.clips[1];
    bar.is_free = true;
    bar.mass_kg = numbers_.between(0.0, 0.05);
    bar.centre_of_mass_m = {1.1 * grid_.length_u_m, 0.5 * grid_.length_v_m, 0.01};
    bar.cord_place_m = {{1.2 * grid_.length_u_m, 0.0, 0.0},
                        {1.2 * grid_.length_u_m, grid_.length_v_m, 0.0}};
    const Eigen::Vector3d first = vector(0.6), second = vector(0.6);
    loads.cord_force_N = {{}, {first, second}};
  }

  Numbers numbers_;
  Grid grid_;
  Cloth cut_;
  Sheet sheet_;
};

TEST(RandomCases, AnswersAreNumbersAndTrue) {
  constexpr unsigned kCases = 250;
  int good = 0;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    SCOPED_TRACE(seed);
    const RandomCase random(seed);
    const Sheet& sheet = random.sheet();
    State state = random.state;
    auto solver = EquilibriumSolver::make(sheet.model, random.boundary, random.obstacles);
    ASSERT_TRUE(solver) << solver.error().message;
    const auto result = solver->solve(sheet.parameters, random.loads, state, random.options);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_TRUE(state.x.allFinite() && result->by_node.allFinite());
    EXPECT_TRUE(std::isfinite(result->energy_J) && std::isfinite(result->last.net_force_N));
    EXPECT_FALSE(describe(*result, random.options).empty());
    good += result->is_good(random.options);
    if (!result->is_good(random.options)) continue;

    // net force and energy, put together anew without what the solver remembers
    const Unknowns unknowns(random.boundary, sheet.model.matrix());
    const Contact none;
    const Potential potential(sheet.model, sheet.parameters, random.boundary, unknowns,
                              random.loads, none);
    PotentialValue value, start;
    ASSERT_TRUE(potential.evaluate(state, value));
    Eigen::Index k = 0;
    for (const Obstacle& obstacle : random.obstacles) {
      for (const int node : unknowns.free_nodes()) {
        const Gap g = gap(obstacle, state.x.segment<3>(3 * static_cast<Eigen::Index>(node)));
        EXPECT_GE(g.value_m, -random.options.contact_depth_m);
        value.by_node.segment<3>(3 * static_cast<Eigen::Index>(node)) -=
            result->contact_force_N[k++] * g.normal;
      }
    }
    unknowns.reduce_gradient(random.loads, state, value.by_node, value.by_unknown);
    const double net_force_N = unknowns.net_force_N(value.by_unknown);
    EXPECT_LE(net_force_N, random.options.tolerance_N + 1e-7);
    EXPECT_NEAR(net_force_N, result->last.net_force_N, 1e-9 + 1e-6 * net_force_N);
    State from = random.state;
    place_clips(random.boundary, from);
    if (random.obstacles.empty() && potential.evaluate(from, start)) {
      EXPECT_LE(value.energy_J, start.energy_J);
    }
  }
  EXPECT_GE(good, static_cast<int>(0.98 * kCases)) << "most of them have a state of rest";
}

}  // namespace
}  // namespace tenter::mechanics::testing
