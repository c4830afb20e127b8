// SPDX-License-Identifier: GPL-3.0-or-later
// Steps allocate nothing: a solve of many steps takes as many allocations as one of few.
#include <gtest/gtest.h>

#include "tests/server/mechanics/equilibrium/sheets.h"
#include "tests/server/mechanics/sparse/count_allocations.h"

namespace tenter::mechanics::testing {
namespace {

TEST(Allocations, StepsTakeNothingFromTheHeap) {
  const Grid grid{13, 13, 0.1, 0.1};
  const Sheet sheet(cloth_of_grid(grid, Diagonals::alternating).value(),
                    preset_with("cloth_stvk", {}));
  State start{flat(sheet.cloth.mesh), {Pose{}}};
  Boundary boundary;
  boundary.held = {0, 12};
  Clip bar = clip_on("bar", {grid.node(5, 12), grid.node(6, 12), grid.node(7, 12)}, start.x, {});
  bar.is_free = true;
  bar.mass_kg = 0.002;
  bar.centre_of_mass_m = {0.05, 0.11, 0.0};
  boundary.clips = {bar};
  const std::vector<Obstacle> floor = {Plane{{0.0, 0.0, -0.02}, Eigen::Vector3d::UnitZ()}};
  auto solver = EquilibriumSolver::make(sheet.model, boundary, floor).value();
  const Loads loads = weight(sheet.cloth.mesh, 0.2);
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  const auto taken = [&](int steps, Minimiser minimiser) {
    options.max_iterations = steps;
    options.minimiser = minimiser;
    State state = start;
    const long before = test::allocations();
    const auto result = solver.solve(sheet.parameters, loads, state, options);
    const long after = test::allocations();
    EXPECT_EQ(result->iterations, steps);
    return after - before;
  };
  for (const Minimiser minimiser :
       {Minimiser::newton, Minimiser::additive_lm, Minimiser::relaxation}) {
    taken(30, minimiser);
    const long few = taken(3, minimiser);
    EXPECT_EQ(taken(30, minimiser), few) << static_cast<int>(minimiser);
    EXPECT_GT(few, 0) << "the counter counts";
    EXPECT_LT(few, 100);
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
