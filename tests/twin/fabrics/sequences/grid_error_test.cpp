// SPDX-License-Identifier: GPL-3.0-or-later
// What two coarse grids say of a third that is four times finer.
#include "server/estimation/sequences/discretisation/grid_error.h"

#include <gtest/gtest.h>

#include "tests/twin/fabrics/sequences/same_mesh.h"

namespace tenter::twin {
namespace {

using estimation::Sequence;

constexpr int kCells = 6;

/// The picture frame on a grid, with what the finest one measures.
struct ThreeGrids {
  Sequence coarse, fine;
  MeasuredTwin on_coarse;
};
ThreeGrids three_grids() {
  const Fabric wool = fabric("18");
  const Protocol protocol = make_protocol(wool, "shear", {.frames = 3, .cells = kCells});
  GridOptions grid;
  grid.points_m = {{0.04, 0.06}, {0.05, 0.05}, {0.053, 0.071}};
  const auto on = [&](int times) {
    grid.nodes = times * kCells + 1;
    return same_mesh_twin(wool, protocol, grid).value();
  };
  const Sequence finest = on(4).sequence;
  ThreeGrids grids{{}, on(2).sequence, on(1)};
  grids.coarse = grids.on_coarse.sequence;
  for (Sequence* sequence : {&grids.coarse, &grids.fine})
    for (std::size_t f = 0; f < finest.frames.size(); ++f) {
      sequence->frames[f].points_m = finest.frames[f].points_m;
      sequence->frames[f].forces_N = finest.frames[f].forces_N;
    }
  return grids;
}

TEST(GridError, TwoGridsTellMostOfWhatAFinerOneMeasures) {
  const ThreeGrids grids = three_grids();
  const model::Model truth = fabric_model(fabric("18"));
  constexpr double kShare = 0.2;
  const auto error =
      estimation::grid_error(truth, grids.coarse, grids.fine, {.share_as_sigma = kShare});
  ASSERT_TRUE(error) << error.error().message;
  const Sequence better = without_grid_error(grids.coarse, *error);
  double before = 0.0, after = 0.0, scale = 0.0;
  for (std::size_t f = 0; f < better.frames.size(); ++f) {
    ASSERT_TRUE(error->frames[f].rests);
    const Eigen::VectorXd& on_coarse = grids.on_coarse.sequence.frames[f].forces_N;
    before += (on_coarse - grids.coarse.frames[f].forces_N).squaredNorm();
    after += (on_coarse - better.frames[f].forces_N).squaredNorm();
    scale += on_coarse.squaredNorm();
    EXPECT_EQ(better.frames[f].points_m, grids.coarse.frames[f].points_m);
  }
  EXPECT_GT(before, std::pow(0.02, 2) * scale);  // there is something to tell
  EXPECT_LT(after, std::pow(0.3, 2) * before);
  // what is taken off leaves a share of itself as sigma
  for (std::size_t k = 0; k < better.forces.size(); ++k) {
    double squares = 0.0;
    for (const auto& frame : error->frames)
      squares += std::pow(frame.forces_N[static_cast<Eigen::Index>(k)], 2) / 3.0;
    const double sigma = grids.coarse.forces[k].sigma_N;
    EXPECT_NEAR(better.forces[k].sigma_N, std::hypot(sigma, kShare * std::sqrt(squares)),
                1e-12 * sigma);
  }
}

TEST(GridError, GridsThatCannotBeComparedAreToldSo) {
  const ThreeGrids grids = three_grids();
  const model::Model truth = fabric_model(fabric("18"));
  EXPECT_FALSE(estimation::grid_error(truth, grids.fine, grids.coarse, {}));
  EXPECT_FALSE(estimation::grid_error(truth, grids.coarse, grids.coarse, {}));
  EXPECT_FALSE(estimation::grid_error(truth, grids.coarse, grids.fine, {.order = 0.0}));
  EXPECT_FALSE(estimation::grid_error(truth, grids.coarse, grids.fine, {.share_as_sigma = -0.1}));
  Sequence other = grids.fine;
  other.points.pop_back();
  EXPECT_FALSE(estimation::grid_error(truth, grids.coarse, other, {}));
  other = grids.fine;
  other.frames[1].forces_N[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(estimation::grid_error(truth, grids.coarse, other, {}));
}

}  // namespace
}  // namespace tenter::twin
