// SPDX-License-Identifier: GPL-3.0-or-later
// What two coarse grids say of a third that is four times finer, and of its curves.
#include "server/estimation/sequences/discretisation/grid_error.h"

#include <gtest/gtest.h>

#include "common/model/catalogue.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/refit/grid_free_fit.h"
#include "server/mechanics/law.h"
#include "tests/twin/fabrics/sequences/coverage.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

namespace tenter::twin {
namespace {

using estimation::Sequence;

constexpr int kCoarseCells = 6;

/// The picture frame on a grid, with what the finest one measures.
struct ThreeGrids {
  Sequence coarse, fine;
  MeasuredTwin on_coarse;
};
ThreeGrids three_grids(const Fabric& wool = fabric("18")) {
  const Protocol protocol = make_protocol(wool, "shear", {.frames = 3, .cells = kCoarseCells});
  GridOptions grid;
  grid.points_m = {{0.04, 0.06}, {0.05, 0.05}, {0.053, 0.071}};
  const auto on = [&](int times) {
    grid.nodes = times * kCoarseCells + 1;
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

/// Simulated forces of all frames, one path.
std::vector<Eigen::VectorXd> forces_on_path(const model::Model& model, const Sequence& sequence) {
  auto evaluator = estimation::SequenceEvaluator::make(model, {sequence}).value();
  Eigen::VectorXd residuals;
  EXPECT_EQ(evaluator.evaluate(mechanics::term_parameters(model), residuals, nullptr),
            mechanics::PathStatus::ok);
  std::vector<Eigen::VectorXd> forces;
  for (const auto& frame : sequence.frames) forces.push_back(frame.forces_N);
  const int first = 3 * static_cast<int>(sequence.points.size());
  for (int r = 0; r < evaluator.row_count(); ++r) {
    const estimation::Row& row = evaluator.rows()[static_cast<std::size_t>(r)];
    const int k = row.channel - first;
    if (k >= 0)
      forces[static_cast<std::size_t>(row.frame)][k] +=
          residuals[r] * sequence.forces[static_cast<std::size_t>(k)].sigma_N;
  }
  return forces;
}

TEST(GridError, OfAModelThatRemembersIsThatOfItsPath) {
  const ThreeGrids grids = three_grids();
  model::Model rubbing = fabric_model(fabric("18"));
  model::Term friction = rubbing.terms[2];
  friction.id = "shear_friction";
  friction.law.name = "dahl";
  friction.law.parameters =
      model::default_parameters(*model::find_law("dahl"), 1, model::Domain::membrane);
  friction.law.parameters[1].value = 20.0;
  friction.law.parameters[3].value = 0.2;  // longer than the way: what was before is not forgotten
  rubbing.terms.push_back(friction);
  const auto error = estimation::grid_error(rubbing, grids.coarse, grids.fine, {.order = 1.0});
  ASSERT_TRUE(error) << error.error().message;
  const auto coarse = forces_on_path(rubbing, grids.coarse),
             fine = forces_on_path(rubbing, grids.fine);
  const Eigen::VectorXd& last = error->frames.back().forces_N;
  const Eigen::VectorXd expected = 2.0 * (fine.back() - coarse.back());
  EXPECT_GT(last.norm(), 0.02 * fine.back().norm());
  EXPECT_LT((last - expected).norm(), 1e-4 * last.norm());
  // a frame by itself would be another: it comes from a sheet that was never sheared
  Sequence alone = grids.coarse;
  alone.frames = {grids.coarse.frames.back()};
  EXPECT_GT((forces_on_path(rubbing, alone)[0] - coarse.back()).norm(), 0.05 * last.norm());
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

/// Shear alone is looked for, from a third too much.
model::Model start_of(const model::Model& truth) {
  model::Model start = truth;
  for (model::Term& term : start.terms)
    for (model::Parameter& p : term.law.parameters) p.fixed = term.id != "shear";
  start.terms[2].law.parameters[0].value *= 1.33;
  return start;
}

TEST(GridFreeFit, FindsTheCurveOfTheClothNotOfTheGrid) {
  const Fabric wool = reached_everywhere(fabric("18"));
  const ThreeGrids grids = three_grids(wool);
  const model::Model truth = fabric_model(wool);
  const double shear = truth.terms[2].law.parameters[0].value;
  const estimation::RoleSequence coarse{estimation::Role::shear, grids.coarse};
  estimation::StageTask all{"all", {"shear"}, {}, {coarse}};
  model::Model on_grid = start_of(truth);
  const auto record = estimation::fit_stage(on_grid, all, {});
  ASSERT_TRUE(record && record->done);
  const auto off = [&](const model::Model& model) {
    return model.terms[2].law.parameters[0].value / shear - 1.0;
  };
  EXPECT_LT(off(on_grid), -0.03);  // the grid is too stiff, its curve makes up for that

  const double order = estimation::order_of(grids.coarse, false);
  EXPECT_EQ(order, 1.3);
  const std::vector<estimation::OnTwoGrids> measured = {{coarse, grids.fine, order}};
  estimation::GridFreeOptions options;
  const auto fit = estimation::grid_free_fit(on_grid, measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->settled);
  EXPECT_LT(fit->change_sigmas, options.settled_sigmas);
  EXPECT_GE(fit->rounds, 1);
  EXPECT_EQ(fit->stages.size(), static_cast<std::size_t>(fit->rounds));
  EXPECT_LT(std::abs(off(fit->model)), 0.5 * std::abs(off(on_grid)));
  // as large as what the coarse grid is wrong by at the true curve, and of these forces
  const auto size = size_of(fit->errors[0], grids.coarse, estimation::ObservationKind::force);
  EXPECT_EQ(size.rows, 3 * static_cast<int>(grids.coarse.forces.size()));
  double squares = 0.0;
  for (std::size_t f = 0; f < 3; ++f)
    squares += (grids.on_coarse.sequence.frames[f].forces_N - grids.coarse.frames[f].forces_N)
                   .squaredNorm();
  EXPECT_NEAR(size.rms, std::sqrt(squares / size.rows), 0.3 * std::sqrt(squares / size.rows));
  EXPECT_GE(size.largest, size.rms);

  // the same bytes for two threads; one that is stopped says so
  options.stage.threads = 2;
  const auto again = estimation::grid_free_fit(on_grid, measured, options);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->model.terms[2].law.parameters[0].value,
            fit->model.terms[2].law.parameters[0].value);
  EXPECT_EQ(again->errors[0].frames[2].forces_N, fit->errors[0].frames[2].forces_N);
  options.stage.on_progress = [](const estimation::StageProgress& p) { return p.iteration == 0; };
  const auto stopped = estimation::grid_free_fit(on_grid, measured, options);
  ASSERT_TRUE(stopped);
  EXPECT_TRUE(stopped->stopped);
}

TEST(GridFreeFit, NeedsSomethingToFitTo) {
  const ThreeGrids grids = three_grids();
  const model::Model truth = fabric_model(fabric("18"));
  std::vector<estimation::OnTwoGrids> measured = {
      {{estimation::Role::evaluation, grids.coarse}, grids.fine, 1.3, false}};
  EXPECT_FALSE(estimation::grid_free_fit(truth, measured, {}));
  measured[0].is_fitted = true;
  estimation::GridFreeOptions options;
  options.most_rounds = 0;
  EXPECT_FALSE(estimation::grid_free_fit(truth, measured, options));
}

}  // namespace
}  // namespace tenter::twin
