// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet that curls by itself: its bending energy k/2 (eps - e)^2 is the one without curl and a
// constant stress c = -k e on the same bend, up to a constant. Bends have a sign: with the other c
// it curls to the other side.
#include <gtest/gtest.h>

#include <cmath>

#include "server/mechanics/equilibrium/equilibrium.h"
#include "server/mechanics/mesh/hinges.h"

namespace tenter::mechanics {
namespace {

model::Term term_of(const char* strain, const char* law, double value) {
  model::Term term;
  term.id = std::string(strain) + "_" + law;
  term.strain.name = strain;
  term.law.name = law;
  term.law.parameters.resize(1);
  term.law.parameters[0].value = value;
  return term;
}

constexpr double kBending_N_m = 2e-4;
constexpr int kColumns = 13, kRows = 3;

/// Angle from the held end to the free end of a strip without weight, positive upwards.
double curl(double constant_stress) {
  const Grid grid{kColumns, kRows, 0.12, 0.02};
  const Cloth cloth = cloth_of_grid(grid, Diagonals::one).value();
  model::Model description;
  for (const char* strain : {"green_u", "green_v", "green_uv"})
    description.terms.push_back(term_of(strain, "linear", 50.0));
  for (const char* strain : {"bend_u", "bend_v", "bend_d"})
    description.terms.push_back(term_of(strain, "linear", kBending_N_m));
  description.terms.push_back(term_of("bend_u", "constant_stress", constant_stress));
  const MeshModel model = MeshModel::make(description, cloth).value();
  Eigen::VectorXd parameters(7);
  parameters << 50.0, 50.0, 50.0, kBending_N_m, kBending_N_m, kBending_N_m, constant_stress;
  Boundary boundary;
  State state;
  state.x.setZero(3 * cloth.mesh.node_count());
  for (int n = 0; n < cloth.mesh.node_count(); ++n)
    state.x.segment<2>(3 * n) = cloth.mesh.material_m.col(n);
  for (int j = 0; j < kRows; ++j)
    for (const int i : {0, 1}) boundary.held.push_back(grid.node(i, j));
  auto solver = EquilibriumSolver::make(model, boundary).value();
  EquilibriumOptions options;
  options.tolerance_N = 1e-10;
  const auto result = solver.solve(parameters, {}, state, options);
  EXPECT_TRUE(result && result->is_good(options));
  const auto place = [&](int i) -> Eigen::Vector3d {
    return state.x.segment<3>(3 * grid.node(i, 1));
  };
  const Eigen::Vector3d end = place(kColumns - 1) - place(kColumns - 2);
  return std::atan2(end.z(), end.x());
}

/// Every fold takes the same angle e h, and folds across the strip stretch nothing.
TEST(RestCurvature, AStripCurlsToItAndTheOtherWay) {
  const Cloth cloth = cloth_of_grid({kColumns, kRows, 0.12, 0.02}, Diagonals::one).value();
  double height_m = 0.0;
  for (const Hinge& hinge : cloth.hinges)
    if (hinge.bend == Direction::weft) height_m = hinge.height_m;
  const double folds = kColumns - 2;
  const double rest_curvature = 20.0;  // 1/m
  const double angle = folds * rest_curvature * height_m;
  EXPECT_GT(angle, 0.5);
  const double there = curl(-kBending_N_m * rest_curvature);
  EXPECT_NEAR(there, -angle, 1e-6 * angle);  // a ridge seen from above
  EXPECT_NEAR(curl(kBending_N_m * rest_curvature), -there, 1e-6 * angle);
}

}  // namespace
}  // namespace tenter::mechanics
