// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/data/start.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/stage.h"

namespace tenter::diagnosis {
namespace {

/// A sheet is thinner than it is wide, and so less stiff in bending, E t^3 / 12, than its
/// membrane's stiffness, E t, times the square of its diagonal. Captures that hardly bend would let
/// it grow until numbers no longer tell a frame that rests from one that does not. Nor is it as
/// thin as nothing: without any bending a sheet that hangs has motions that cost nothing.
void bound_bending(const FieldData& data, model::Model& model) {
  constexpr double kThinnest_m = 1e-5;
  double stiffest_N_per_m = 0.0, softest_N_per_m = std::numeric_limits<double>::infinity();
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) {
      if (p.unit != "N/m" || !(p.value > 0.0)) continue;
      stiffest_N_per_m = std::max(stiffest_N_per_m, p.value);
      softest_N_per_m = std::min(softest_N_per_m, p.value);
    }
  double diagonal_m2 = 0.0;
  for (const estimation::Sequence& sequence : data.sequences) {
    const Eigen::Matrix2Xd& at = sequence.cloth.mesh.material_m;
    diagonal_m2 =
        std::max(diagonal_m2, (at.rowwise().maxCoeff() - at.rowwise().minCoeff()).squaredNorm());
  }
  const double most_N_m = stiffest_N_per_m * diagonal_m2;
  if (!(most_N_m > 0.0)) return;
  const double least_N_m = softest_N_per_m * kThinnest_m * kThinnest_m / 12.0;
  for (model::Term& term : model.terms)
    for (model::Parameter& p : term.law.parameters) {
      if (p.unit != "N m" || p.fixed) continue;
      p.lower = std::max(p.lower.value_or(least_N_m), least_N_m);
      p.upper = std::max(p.lower.value_or(0.0), std::min(p.upper.value_or(most_N_m), most_N_m));
      p.value = std::clamp(p.value, *p.lower, *p.upper);
    }
}

/// A joint stage of the staged fit: its start is the equation gap's where that is the better one,
/// and frames without rest are left out.
Expected<model::Model> after_stage(const model::Model& start, const Control& control,
                                   FieldData& data, std::vector<std::string>& dropped) {
  estimation::StageTask task;
  task.name = "all";
  task.refine = false;
  for (const model::Term& term : start.terms) task.terms.push_back(term.id);
  for (const estimation::Sequence& sequence : data.sequences)
    task.sequences.push_back({estimation::Role::evaluation, sequence});
  estimation::StageOptions options;
  options.threads = control.threads;
  options.channels = estimation::Channels::all;
  options.on_progress = [&](const estimation::StageProgress& p) {
    control.report({"start", start.name, p.iteration, p.cost, 0.02});
    return !control.stop.stop_requested();
  };
  model::Model model = start;
  auto record = estimation::fit_stage(model, task, options);
  if (!record) return tl::unexpected(record.error());
  if (!record->done)
    return bad_input("the model \"" + start.name +
                     "\" cannot be fitted to these captures: " + record->message);
  for (const auto& frame : record->dropped)
    dropped.push_back(frame.sequence + ", frame " + std::to_string(frame.frame) + ": " +
                      frame.reason);
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    std::vector<int> kept;
    for (int f = 0; f < static_cast<int>(data.sequences[s].frames.size()); ++f) {
      const bool is_dropped =
          std::any_of(record->dropped.begin(), record->dropped.end(), [&](const auto& frame) {
            return frame.sequence == data.sequences[s].name && frame.frame == f + 1;
          });
      if (!is_dropped) kept.push_back(f);
    }
    if (kept.size() < data.sequences[s].frames.size())
      estimation::keep_frames(data.sequences[s], kept);
  }
  return model;
}

bool is_stiffness(const model::Parameter& before, const model::Parameter& after) {
  return after.unit == "N/m" && !after.fixed && before.value > 0.0;
}

/// Lower median; 0 of none.
double middle_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[(values.size() - 1) / 2];
}

/// What the search for a start sent to nowhere, for captures do not determine it, starts where the
/// others did: beside a shear of 1e15 N/m numbers tell nothing of the rest.
void bring_back(const model::Model& start, model::Model& model) {
  constexpr double kNowhere = 300.0;  // factor on what is usual
  const auto before = estimation::parameters_of(start);
  const auto after = estimation::parameters_of(model);
  if (before.size() != after.size()) return;
  std::vector<double> factors;
  for (std::size_t i = 0; i < after.size(); ++i)
    if (is_stiffness(*before[i], *after[i])) factors.push_back(after[i]->value / before[i]->value);
  const double factor = middle_of(factors);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (!is_stiffness(*before[i], *after[i])) continue;
    const double usual = factor * before[i]->value;
    if (after[i]->value > kNowhere * usual || after[i]->value < usual / kNowhere)
      after[i]->value = usual;
  }
}

}  // namespace

std::optional<model::Model> scaled_to_forces(const model::Model& start, const FieldData& data) {
  const auto foretold = predict_field(start, data, {}, {});
  if (!foretold) return std::nullopt;
  double product = 0.0, square = 0.0;
  for (std::size_t r = 0; r < foretold->rows.size(); ++r) {
    const estimation::Row& row = foretold->rows[r];
    const estimation::Sequence& sequence = data.sequences[static_cast<std::size_t>(row.curve)];
    const estimation::Observations channels(sequence);
    if (channels.kind(sequence, row.channel) != estimation::ObservationKind::force) continue;
    const double sigma = channels.sigma(sequence, row.channel);
    const double measured =
        channels.measured(sequence.frames[static_cast<std::size_t>(row.frame)], row.channel);
    const double said = measured + sigma * foretold->at.fit.residuals[static_cast<Eigen::Index>(r)];
    product += measured * said / (sigma * sigma);
    square += said * said / (sigma * sigma);
  }
  if (!(product > 0.0) || !(square > 0.0)) return std::nullopt;
  model::Model scaled = start;
  for (model::Parameter* p : estimation::parameters_of(scaled))
    if (p->unit == "N/m" && !p->fixed)
      p->value = std::clamp(p->value * product / square, p->lower.value_or(0.0),
                            p->upper.value_or(std::numeric_limits<double>::infinity()));
  bound_bending(data, scaled);
  return scaled;
}

Expected<model::Model> find_start(const model::Model& start, const Control& control,
                                  FieldData& data, std::vector<std::string>& dropped) {
  auto model = after_stage(start, control, data, dropped);
  if (!model && model.error().kind != ErrorKind::cancelled) {
    const auto scaled = scaled_to_forces(start, data);
    if (auto again = scaled ? after_stage(*scaled, control, data, dropped) : model; again)
      model = std::move(again);
  }
  if (!model) return model;
  bring_back(start, *model);
  bound_bending(data, *model);
  return model;
}

std::vector<std::string> hold_undetermined(const model::Model& start,
                                           const estimation::RowMatrix* jacobian,
                                           model::Model& held) {
  constexpr double kDetermined = 10.0, kUnseen = 3.0;  // standard deviations of all readings
  constexpr double kAway = 30.0, kStiffest = 100.0;    // factors on what is usual
  constexpr double kNothing = 0.3, kStays = 10.0;      // of a deviation; factor on where it is
  const auto names = estimation::parameter_names(held);
  const auto before = estimation::parameters_of(start);
  const auto after = estimation::parameters_of(held);
  std::vector<std::string> away;
  if (before.size() != after.size()) return away;
  const auto shown = [&](std::size_t i, double value) {
    return jacobian->col(static_cast<Eigen::Index>(i)).norm() * std::abs(value);
  };
  std::vector<double> factors;
  for (std::size_t i = 0; i < after.size(); ++i)
    if (is_stiffness(*before[i], *after[i]) &&
        (jacobian == nullptr || shown(i, after[i]->value) > kDetermined))
      factors.push_back(after[i]->value / before[i]->value);
  if (factors.empty()) return away;
  const double factor = middle_of(factors);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (!is_stiffness(*before[i], *after[i])) continue;
    const double usual = before[i]->value * factor;
    const bool ran = after[i]->value > kAway * usual || after[i]->value < usual / kAway;
    if (jacobian != nullptr && shown(i, usual) > kUnseen) continue;
    if (!ran) {
      if (jacobian == nullptr || shown(i, after[i]->value) > kUnseen) continue;
      after[i]->fixed = shown(i, after[i]->value) < kNothing;
      after[i]->lower = std::max(after[i]->lower.value_or(0.0), after[i]->value / kStays);
      after[i]->upper = kStays * after[i]->value;
      continue;
    }
    if (after[i]->value > usual) {
      after[i]->value = kStiffest * usual;
      after[i]->upper = after[i]->value;
    } else {
      after[i]->value = usual;
      after[i]->fixed = true;
    }
    away.push_back(names[i]);
  }
  return away;
}

}  // namespace tenter::diagnosis
