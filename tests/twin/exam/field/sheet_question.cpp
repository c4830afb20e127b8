// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/field/sheet_question.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/model/presets.h"
#include "tests/twin/fabrics/sequences/sequence_of.h"

namespace tenter::exam {
namespace {

/// Only what is seen, under a name that says which forces are read.
twin::Protocol shown(const twin::SheetPlan& plan) {
  twin::Protocol protocol = plan.path;
  protocol.name = (plan.is_frame ? "shear_" : "stretch_") + plan.name;
  protocol.frames.clear();
  std::size_t next = 0;
  for (const int f : plan.seen) {
    double duration_s = 0.0;
    for (; next <= static_cast<std::size_t>(f); ++next)
      duration_s += plan.path.frames[next].duration_s;
    protocol.frames.push_back(plan.path.frames[static_cast<std::size_t>(f)]);
    protocol.frames.back().duration_s = duration_s;
  }
  return protocol;
}

/// Positions of the grid's nodes, which follow the tracked places.
mechanics::State start_of(const twin::SheetTwin& done, std::size_t frame, std::size_t tracked,
                          const std::vector<mechanics::Pose>& clips) {
  const Eigen::Matrix3Xd& all = done.positions_m[frame];
  const Eigen::Matrix3Xd at = all.rightCols(all.cols() - static_cast<Eigen::Index>(tracked));
  mechanics::State start;
  start.x = Eigen::Map<const Eigen::VectorXd>(at.data(), at.size());
  start.clips = clips;
  return start;
}

/// On a grid of `fineness` cells to one of the suite's.
estimation::Sequence sequence_of_plan(const twin::SheetTwins& twins, std::size_t p, int fineness) {
  const twin::SheetPlan& plan = twins.suite.plans[p];
  const twin::Protocol protocol = shown(plan);
  estimation::Sequence sequence = twin::sequence_of(twins.stated, protocol,
                                                    {.nodes = fineness * twins.suite.grid_cells + 1,
                                                     .points_m = twins.suite.places_m,
                                                     .point_sigma_m = twins.stated_noise.points_m});
  sequence.name = plan.name;
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    sequence.forces[k].name = plan.cells[k];
    sequence.forces[k].sigma_N = twins.stated_noise.forces_N;
  }
  // places under clips are no channels
  std::vector<Eigen::Index> channels;
  for (std::size_t k = 0, next = 0; k < twins.suite.places_m.size(); ++k)
    if (next < sequence.points.size() &&
        sequence.points[next].material_m == twins.suite.places_m[k]) {
      channels.push_back(static_cast<Eigen::Index>(k));
      ++next;
    }
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    estimation::SequenceFrame& frame = sequence.frames[f];
    const twin::SheetReadings::Frame& read = twins.readings.plans[p][f];
    frame.points_m = read.points_m(Eigen::all, channels);
    frame.forces_N = read.forces_N;
    const bool has_clock = twins.suite.traits.has_clock || plan.keeps_time;
    frame.duration_s = has_clock ? protocol.frames[f].duration_s : 0.0;
    if (fineness > 1) continue;
    frame.start = start_of(twins.done.plans[p], static_cast<std::size_t>(plan.seen[f]),
                           twins.suite.places_m.size(), frame.clips);
  }
  return sequence;
}

model::Model baseline_of(const twin::SheetTwins& twins) {
  model::Model model = model::preset("cloth_stvk").value();
  const std::size_t membranes = 3;
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    model::Parameter& k = model.terms[t].law.parameters.front();
    k.value = t < membranes ? twins.guess_k_N_m : twins.stated.curves[t].stiffness(0.0);
  }
  if (twins.baseline == twin::SheetBaseline::isotropic) {
    const model::Model isotropic = model::preset("stvk_isotropic").value();
    model.terms.erase(model.terms.begin(), model.terms.begin() + membranes);
    model.terms.insert(model.terms.begin(), isotropic.terms.begin(), isotropic.terms.end());
    for (std::size_t t = 0; t < isotropic.terms.size(); ++t)
      model.terms[t].law.parameters.front().value = 0.5 * twins.guess_k_N_m;
    model.name = isotropic.name;
  }
  return model;
}

}  // namespace

diagnosis::SheetRequest request_of(const twin::SheetTwins& twins) {
  diagnosis::SheetRequest request;
  request.model = baseline_of(twins);
  // what was recorded without time cannot speak of rates, beside what was
  const bool drops_timeless = !twins.suite.traits.has_clock &&
                              std::ranges::any_of(twins.suite.plans, &twin::SheetPlan::keeps_time);
  for (std::size_t p = 0; p < twins.suite.plans.size(); ++p) {
    const twin::SheetPlan& plan = twins.suite.plans[p];
    if (drops_timeless && !plan.keeps_time) continue;
    request.sequences.push_back({"twin" + std::to_string(p), plan.name,
                                 estimation::Role::evaluation, sequence_of_plan(twins, p, 1),
                                 plan.held_out});
    request.sequences.back().finer = sequence_of_plan(twins, p, 2);
  }
  return request;
}

}  // namespace tenter::exam
