// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/sheet_grid_free.h"

#include <algorithm>
#include <utility>

#include "server/estimation/staged/refit/grid_free_fit.h"

namespace tenter::jobs {
namespace {

using estimation::GridError;
using estimation::ObservationKind;
using estimation::OnTwoGrids;

std::vector<OnTwoGrids> on_two_grids(const std::vector<SheetInput>& inputs) {
  std::vector<OnTwoGrids> measured;
  for (const SheetInput& input : inputs) {
    OnTwoGrids& one = measured.emplace_back();
    one.coarse = {input.role, input.sequence()};
    one.fine = *input.finer;
    // inside of an outline that is no rectangle lies an irregular mesh; the door refuses equal
    // cells
    const bool is_grid = !input.sequence().cloth.mesh.triangle_layer.empty();
    one.order = estimation::order_of(one.coarse.sequence, is_grid);
    one.is_fitted = !input.held_out;
  }
  return measured;
}

GridFreeFound::OfCapture told_of(const OnTwoGrids& measured, const GridError& error) {
  GridFreeFound::OfCapture told;
  told.order = measured.order;
  told.force = size_of(error, measured.coarse.sequence, ObservationKind::force);
  told.position = size_of(error, measured.coarse.sequence, ObservationKind::position);
  told.frames_without =
      static_cast<int>(std::count_if(error.frames.begin(), error.frames.end(),
                                     [](const GridError::Frame& frame) { return !frame.rests; }));
  told.measured = measured.coarse.sequence;
  told.error = error;
  return told;
}

}  // namespace

Expected<GridFreeFound> sheet_grid_free(model::Model& model, SheetFindings& found,
                                        const estimation::StagedOptions& how,
                                        const RequestWork& work) {
  const std::vector<OnTwoGrids> measured = on_two_grids(found.inputs);
  for (SheetInput& input : found.inputs) input.finer.reset();
  estimation::GridFreeOptions options;
  options.stage = how.stage;
  options.staged = how;
  if (found.options.staged) options.start = &found.start;
  options.stage.on_frame = nullptr;
  options.stage.on_progress = [&](const estimation::StageProgress& progress) {
    work.report({progress.stage, "", progress.iteration, progress.cost, work.fraction});
    return !work.stop.stop_requested();
  };
  auto fit = estimation::grid_free_fit(model, measured, options);
  if (!fit) return tl::unexpected(fit.error());
  if (fit->stopped || work.stop.stop_requested())
    return fail(ErrorKind::cancelled, "the fit was stopped");
  model = std::move(fit->model);
  GridFreeFound result;
  result.settled = fit->settled;
  result.change_sigmas = fit->change_sigmas;
  result.rounds = fit->rounds;
  result.share_as_sigma = options.share_as_sigma;
  for (std::size_t s = 0; s < fit->stages.size(); ++s) {
    found.stages.push_back(std::move(fit->stages[s]));
    found.stage_terms.push_back(std::move(fit->terms[s]));
  }
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    result.captures.push_back(told_of(measured[i], fit->errors[i]));
    found.inputs[i].captured.sequence =
        without_grid_error(measured[i].coarse.sequence, fit->errors[i]);
  }
  return result;
}

void put_back_grid_error(SheetFindings& found) {
  if (!found.requested.grid_free) return;
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    const GridFreeFound::OfCapture& of = found.requested.grid_free->captures[i];
    found.inputs[i].captured.sequence = of.measured;
    Eigen::MatrixXd& shown = found.after[i].value;
    for (std::size_t f = 0; f < of.error.frames.size(); ++f) {
      const GridError::Frame& frame = of.error.frames[f];
      auto column = shown.col(static_cast<Eigen::Index>(f));
      const Eigen::Index points = frame.points_m.size(), forces = frame.forces_N.size();
      column.head(points) += Eigen::Map<const Eigen::VectorXd>(frame.points_m.data(), points);
      column.segment(points, forces) += frame.forces_N;
      column.tail(frame.scalars.size()) += frame.scalars;
    }
  }
}

}  // namespace tenter::jobs
