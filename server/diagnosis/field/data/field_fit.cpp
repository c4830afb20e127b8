// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/data/field_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "server/diagnosis/field/data/structure.h"
#include "server/estimation/least_squares/dissipation.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::diagnosis {
namespace {

using estimation::SequenceEvaluator;

Expected<SequenceEvaluator> evaluator_of(const model::Model& model, const FieldData& data,
                                         const FieldStates& starts,
                                         const FieldFitOptions& options) {
  std::vector<estimation::Sequence> sequences = data.sequences;
  for (std::size_t s = 0; s < starts.size(); ++s)
    for (std::size_t f = 0; f < starts[s].size(); ++f) sequences[s].frames[f].start = starts[s][f];
  estimation::SequenceOptions how;
  how.threads = options.threads;
  how.tolerance_N = options.tolerance_N;
  how.starts_are_near = !starts.empty();
  how.weighting.rule = estimation::WeightingRule::by_noise;
  return SequenceEvaluator::make(model, std::move(sequences), how);
}

estimation::FitOptions fit_options(const model::Model& model, const FieldFitOptions& options) {
  estimation::FitOptions how;
  how.method = estimation::FitMethod::bounded_marquardt;
  how.max_iterations = options.max_iterations;
  how.tolerance = options.tolerance;
  how.friction = estimation::friction_places(model);
  how.on_iteration = options.on_iteration;
  return how;
}

/// Errors are of as many rows as the field says are independent, not of as many as one channel's
/// frames alone would say.
void count_independent(const FieldData& data, const std::vector<estimation::Row>& rows,
                       estimation::FitResult& fit) {
  double moving = 0.0;
  for (const estimation::ParameterState s : fit.states)
    moving += s == estimation::ParameterState::free || s == estimation::ParameterState::flat;
  const double before = std::max(1.0, fit.effective_rows - moving);
  fit.effective_rows =
      std::min(fit.effective_rows, independent_rows(data.sequences, rows, fit.residuals));
  fit.std_error *= std::sqrt(before / std::max(1.0, fit.effective_rows - moving));
}

}  // namespace

model::Model acting_on(model::Model model, const FieldData& data) {
  std::erase_if(model.corrections, [&](const model::SensorCorrection& c) {
    return std::none_of(
        data.sequences.begin(), data.sequences.end(), [&](const estimation::Sequence& sequence) {
          const bool has_force =
              c.component.empty() ||
              std::any_of(sequence.forces.begin(), sequence.forces.end(),
                          [&](const auto& force) { return force.name == c.component; });
          return has_force && (c.capture.empty() || c.capture == sequence.name);
        });
  });
  return model;
}

int FieldData::block_count() const {
  int count = 0;
  for (const estimation::Sequence& sequence : sequences) {
    int own = 0;
    for (const auto& frame : sequence.frames) own = std::max(own, frame.block + 1);
    count += own;
  }
  return count;
}

Expected<FieldFit> fit_field(const model::Model& start, const FieldData& data,
                             const FieldStates& starts, const FieldFitOptions& options) {
  auto evaluator = evaluator_of(start, data, starts, options);
  if (!evaluator) return tl::unexpected(evaluator.error());
  FieldFit result;
  result.at.model = start;
  result.at.fit = estimation::fit(*evaluator, start, fit_options(start, options));
  // rests of another law may lie where this one has none on the way
  if (!result.at.fit.usable && !starts.empty()) return fit_field(start, data, {}, options);
  if (!result.at.fit.usable)
    return bad_input("the model \"" + start.name +
                     "\" cannot be fitted to these captures: " + result.at.fit.message +
                     (evaluator->failure().empty() ? "" : " (" + evaluator->failure() + ")"));
  count_independent(data, evaluator->rows(), result.at.fit);
  estimation::store(result.at.fit, result.at.model);
  result.at.block_chi2 =
      chi2_by_block(evaluator->rows(), result.at.fit.residuals, data.block_count());
  result.states = evaluator->states();
  result.rows = evaluator->rows();
  return result;
}

Expected<FieldFit> predict_field(const model::Model& model, const FieldData& data,
                                 const FieldStates& starts, const FieldFitOptions& options) {
  const model::Model acting = acting_on(model, data);
  model::Model held = acting;
  for (model::Parameter* p : estimation::parameters_of(held)) p->fixed = true;
  auto result = fit_field(held, data, starts, options);
  if (result) result->at.model = acting;
  return result;
}

/// What all of the captures do not determine is not looked for in a part of them.
estimation::HeldOut cross_validate_field(const FieldFit& at, const FieldData& data,
                                         const estimation::Folds& folds,
                                         const FieldFitOptions& options) {
  model::Model model = at.at.model;
  const auto parameters = estimation::parameters_of(model);
  for (std::size_t i = 0; i < at.at.fit.states.size(); ++i)
    if (at.at.fit.states[i] != estimation::ParameterState::free) parameters[i]->fixed = true;
  auto evaluator = evaluator_of(model, data, at.states, options);
  if (!evaluator) return {};
  // from where the whole data lead it is a few steps, but for what a fold does not determine
  constexpr int kMostSteps = 8;
  FieldFitOptions few = options;
  few.max_iterations = std::min(options.max_iterations, kMostSteps);
  return estimation::cross_validate(*evaluator, model, folds, fit_options(model, few));
}

estimation::Folds field_folds(const FieldData& data, const std::vector<estimation::Row>& rows,
                              const std::string& kind) {
  std::map<std::string, int> labels;
  std::vector<int> label_of;
  label_of.reserve(rows.size());
  for (const estimation::Row& row : rows) {
    const auto s = static_cast<std::size_t>(row.curve);
    const std::string key = kind == "protocols"  ? data.protocols[s]
                            : kind == "captures" ? std::to_string(s)
                            : kind == "blocks"
                                ? "block " + std::to_string(row.block)
                                : std::to_string(s) + ", frame " + std::to_string(row.frame);
    label_of.push_back(labels.emplace(key, static_cast<int>(labels.size())).first->second);
  }
  constexpr int kMostFolds = 6;  // each is a fit of whole sheets
  return estimation::folds_of(kind, label_of, static_cast<int>(labels.size()), kMostFolds);
}

}  // namespace tenter::diagnosis
