// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/run_sheet_fit.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/atomic_write.h"
#include "common/model/document.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/splines/strain_histogram.h"
#include "server/estimation/staged/unseen.h"
#include "server/jobs/sheet_fit/certainty/optimum.h"
#include "server/jobs/sheet_fit/certainty/sheet_profiles.h"
#include "server/jobs/sheet_fit/document/sheet_document.h"
#include "server/jobs/sheet_fit/document/sheet_residuals.h"
#include "server/jobs/sheet_fit/progress/live_progress.h"
#include "server/jobs/sheet_fit/progress/stage_checkpoint.h"
#include "server/jobs/sheet_fit/requests/requests.h"
#include "server/jobs/sheet_fit/requests/sheet_grid_free.h"

namespace tenter::jobs {
namespace {

using estimation::RoleSequence;
using estimation::StagedOptions;
using estimation::StagedResult;
using estimation::StageTask;
using nlohmann::json;

constexpr double kTolerance_N = 1e-7;
constexpr double kCompared = 0.93;  // share of the job that is done then

std::vector<RoleSequence> fitted_sequences(const std::vector<SheetInput>& inputs) {
  std::vector<RoleSequence> measured;
  for (const SheetInput& input : inputs)
    if (!input.held_out) measured.push_back({input.role, input.sequence()});
  return measured;
}

/// All curves and sequences in one stage.
StageTask single_stage(const model::Model& model, std::vector<RoleSequence> measured,
                       bool keep_points) {
  StageTask task;
  task.refine = !keep_points;
  task.name = "all";
  for (const model::Term& term : model.terms) task.terms.push_back(term.id);
  task.sequences = std::move(measured);
  return task;
}

Expected<StagedResult> fit_at_once(const model::Model& start, std::vector<RoleSequence> measured,
                                   const StagedOptions& options, bool keep_points) {
  StagedResult result;
  result.model = start;
  auto record = estimation::fit_stage(
      result.model, single_stage(start, std::move(measured), keep_points), options.stage);
  if (!record) return tl::unexpected(record.error());
  result.stopped = record->stopped;
  result.stages.push_back(std::move(*record));
  if (!result.stopped && options.on_stages_done) options.on_stages_done(result);
  return result;
}

/// Ids of the terms of every stage of the plan, by the stage's name.
std::vector<std::vector<std::string>> terms_of_stages(
    const std::vector<estimation::StageRecord>& stages, const model::Model& model,
    const std::vector<std::vector<StageTask>>& plan) {
  std::vector<std::vector<std::string>> all;
  for (const estimation::StageRecord& stage : stages) {
    std::vector<std::string> terms;
    for (const auto& wave : plan)
      for (const StageTask& task : wave)
        if (task.name == stage.name) terms = task.terms;
    if (terms.empty() && stage.done)
      for (const model::Term& term : model.terms) terms.push_back(term.id);
    all.push_back(std::move(terms));
  }
  return all;
}

/// Terms whose range of strains no stage chose get the one that the fitted frames reach, without
/// outliers.
void add_reached_strains(const SheetFindings& found, model::Model& model) {
  constexpr double kOutliers = 0.005;  // as the stages'
  std::vector<estimation::StrainHistogram> strains;
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    if (found.inputs[i].held_out) continue;
    const auto mesh = mechanics::MeshModel::make(model, found.inputs[i].sequence().cloth);
    std::vector<mechanics::State> states;
    for (const auto& state : found.after[i].states)
      if (state) states.push_back(*state);
    if (mesh) estimation::append(strains, estimation::strain_histograms(*mesh, states));
  }
  for (std::size_t t = 0; t < std::min(strains.size(), model.terms.size()); ++t) {
    const std::string& id = model.terms[t].id;
    const bool is_known = std::any_of(model.strain_ranges.begin(), model.strain_ranges.end(),
                                      [&](const model::StrainRange& r) { return r.term == id; });
    if (is_known || strains[t].is_empty()) continue;
    const auto [lo, hi] = strains[t].range(kOutliers);
    model.strain_ranges.push_back({id, lo, hi});
  }
}

/// Splines of a starting model may have no range yet; stages begin such with a constant.
model::Model comparable(model::Model start) {
  for (model::Term& term : start.terms)
    if (estimation::is_spline(term.law) && !(term.law.range_hi > term.law.range_lo))
      term.law = estimation::as_constant(term.law);
  return start;
}

estimation::StageOptions stage_options(const SheetFitOptions& asked, int threads) {
  estimation::StageOptions options;
  options.threads = threads;
  options.channels = asked.channels;
  options.most_points = asked.max_control_points;
  options.knots_from_data = asked.knots_from_data;
  options.first_guess = asked.first_guess;
  options.loss = asked.loss;
  options.tolerance_N = kTolerance_N;
  return options;
}

/// What the document fixes is held by that already.
void hold_unseen(const SheetFindings& found, StagedOptions& options) {
  const auto diagonal = estimation::terms_of(found.start, estimation::Component::bend_diagonal);
  if (found.options.hold_unseen == HoldUnseen::none || estimation::are_held(found.start, diagonal))
    return;
  options.hold_unseen = true;
  if (found.options.hold_unseen == HoldUnseen::value) options.held_at = found.options.held_at;
  if (found.options.hold_unseen != HoldUnseen::start) return;
  for (const model::Term& term : found.start.terms)
    if (term.id == diagonal.front() && !term.law.parameters.empty())
      options.held_at = term.law.parameters[term.law.parameters.size() / 2].value;
}

Expected<StagedResult> run_stages(const JobInput& input, SheetFindings& found, int threads,
                                  LiveProgress& live, const std::stop_token& stop) {
  const std::vector<RoleSequence> measured = fitted_sequences(found.inputs);
  const StageCheckpoint checkpoint(input.checkpoints, input.spec_json);
  StagedOptions options;
  options.stage = stage_options(found.options, threads);
  hold_unseen(found, options);
  options.stage.on_frame = [&](const estimation::StageFrame& frame) { live.frame(frame); };
  options.stage.on_progress = [&](const estimation::StageProgress& progress) {
    live.iteration(progress);
    return !stop.stop_requested();
  };
  options.on_stages_done = [&](const StagedResult& part) {
    checkpoint.save(part);
    live.stages_done(part.stages.size());
  };
  const auto plan = found.options.staged ? estimation::plan_stages(found.start, measured, options)
                                         : std::vector<std::vector<StageTask>>{};
  std::size_t planned = 1;
  for (const auto& wave : plan) planned += wave.size();
  const auto before = checkpoint.load();
  live.begin(planned, before ? before->stages.size() : 0);
  if (before) options.resume = &*before;
  auto fit = found.options.staged ? estimation::staged_fit(found.start, measured, options)
             : before             ? Expected<StagedResult>(*before)
                      : fit_at_once(found.start, measured, options, found.options.keep_points);
  if (!fit) return tl::unexpected(fit.error());
  if (fit->stopped || stop.stop_requested())
    return fail(ErrorKind::cancelled, "the fit was stopped");
  found.stage_terms = terms_of_stages(fit->stages, fit->model, plan);
  return fit;
}

Expected<void> write(const JobInput& input, const SheetFindings& found) {
  const std::string text = sheet_document(found).dump(1) + "\n";
  if (auto written =
          write_atomically((input.staging / "result.json").string(), text.data(), text.size());
      !written)
    return written;
  return report::write_residuals(sheet_residual_tables(found),
                                 (input.staging / "residuals.h5").string(),
                                 sheet_vertex_residuals(found));
}

}  // namespace

Expected<void> run_sheet_fit(const JobInput& input, const json& spec,
                             std::vector<std::pair<std::string, capture::Capture>> captures,
                             const std::function<void(const JobProgress&)>& report,
                             const std::stop_token& stop) {
  SheetFindings found;
  auto start = model::parse_model(spec.at("model").dump(), "model");
  if (!start) return tl::unexpected(start.error());
  if (auto ok = estimation::without_corrections(*start); !ok) return ok;
  found.start = std::move(*start);
  std::vector<std::string> ids;
  ids.reserve(captures.size());
  for (const auto& [id, capture] : captures) ids.push_back(id);
  auto options = read_sheet_options(spec.value("options", json::object()), ids);
  if (!options) return tl::unexpected(options.error());
  found.options = std::move(*options);
  if (has_springs(found.start)) found.options.has_graded_grid = false;
  report({"prepare", std::to_string(ids.size()) + " captures", 0, 0.0, 0.02});
  auto inputs = sheet_inputs(std::move(captures), found.options);
  if (!inputs) return tl::unexpected(inputs.error());
  found.inputs = std::move(*inputs);

  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  LiveProgress live(report);
  auto fit = run_stages(input, found, threads, live, stop);
  if (!fit) return tl::unexpected(fit.error());
  found.stages = std::move(fit->stages);
  if (std::none_of(found.stages.begin(), found.stages.end(),
                   [](const estimation::StageRecord& s) { return s.done; }))
    return fail(
        ErrorKind::job_failed,
        "no stage could be done: " + (found.stages.empty() ? "" : found.stages.back().message));

  report({"compare", "starting model", 0, 0.0, 0.9});
  auto before = predictions(comparable(found.start), found.inputs, threads, stop);
  if (!before) return tl::unexpected(before.error());
  found.before = std::move(*before);
  const StartCheckpoint starts(input.checkpoints, input.spec_json);
  const RequestWork work{threads, kTolerance_N, kCompared, report, stop, starts};
  if (found.options.without_grid_error) {
    StagedOptions how;
    how.stage = stage_options(found.options, threads);
    hold_unseen(found, how);
    auto grid_free = sheet_grid_free(fit->model, found, how, work);
    if (!grid_free) return tl::unexpected(grid_free.error());
    found.requested.grid_free = std::move(*grid_free);
  }
  const auto predict_again = [&](const model::Model& model) -> Expected<void> {
    report({"compare", "fitted model", 0, 0.0, kCompared});
    auto after = predictions(model, found.inputs, threads, stop);
    if (!after) return tl::unexpected(after.error());
    found.after = std::move(*after);
    return {};
  };
  if (auto ok = predict_again(fit->model); !ok) return ok;
  add_reached_strains(found, fit->model);
  if (auto ok = fulfil_requests(fit->model, found, work, predict_again); !ok) return ok;
  report({"intervals", "", 0, 0.0, 0.96});
  found.optimum = found.requested.optimum ? *found.requested.optimum
                                          : optimum(fit->model, found, threads, kTolerance_N);
  if (found.options.profiles) {
    auto profiles = sheet_profiles(fit->model, found, {threads, kTolerance_N}, report, stop);
    if (!profiles) return tl::unexpected(profiles.error());
    found.profiles = std::move(*profiles);
  }
  put_back_grid_error(found);
  found.fitted = std::move(fit->model);
  add_reached_strains(found, found.fitted);
  if (found.optimum.usable) estimation::store(found.optimum, found.fitted);
  if (!found.fitted.lineage) found.fitted.lineage.emplace();
  found.fitted.lineage->captures.clear();
  for (const SheetInput& one : found.inputs)
    if (!one.held_out) found.fitted.lineage->captures.push_back(one.id);
  report({"write", "", 0, 0.0, 0.98});
  return write(input, found);
}

}  // namespace tenter::jobs
