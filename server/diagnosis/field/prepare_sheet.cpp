// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/prepare_sheet.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "server/diagnosis/field/screen/field_excitation.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/stage.h"

namespace tenter::diagnosis {
namespace {

/// Sequences of one kind; those that say nothing of time get a second a frame.
FieldData gathered(const SheetRequest& request, bool held_out) {
  FieldData data;
  for (const SheetSequence& s : request.sequences) {
    if (s.held_out != held_out) continue;
    data.sequences.push_back(s.sequence);
    estimation::Sequence& sequence = data.sequences.back();
    sequence.weight = 1.0;
    const bool has_clock = std::any_of(sequence.frames.begin(), sequence.frames.end(),
                                       [](const auto& frame) { return frame.duration_s > 0.0; });
    if (!has_clock)
      for (std::size_t f = 1; f < sequence.frames.size(); ++f) sequence.frames[f].duration_s = 1.0;
    data.ids.push_back(s.id);
    data.protocols.push_back(s.title);
    data.has_clock.push_back(has_clock);
    data.has_guessed_noise.push_back(s.has_guessed_noise);
  }
  return data;
}

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
Expected<model::Model> started(const SheetRequest& request, const Control& control,
                               SheetDiagnosis& d) {
  estimation::StageTask task;
  task.name = "all";
  task.refine = false;
  for (const model::Term& term : request.model.terms) task.terms.push_back(term.id);
  for (const estimation::Sequence& sequence : d.data.sequences)
    task.sequences.push_back({estimation::Role::evaluation, sequence});
  estimation::StageOptions options;
  options.threads = control.threads;
  options.channels = estimation::Channels::all;
  options.on_progress = [&](const estimation::StageProgress& p) {
    control.report({"start", request.model.name, p.iteration, p.cost, 0.02});
    return !control.stop.stop_requested();
  };
  model::Model model = request.model;
  auto record = estimation::fit_stage(model, task, options);
  if (!record) return tl::unexpected(record.error());
  if (!record->done)
    return bad_input("the model \"" + request.model.name +
                     "\" cannot be fitted to these captures: " + record->message);
  for (const auto& frame : record->dropped)
    d.dropped.push_back(frame.sequence + ", frame " + std::to_string(frame.frame) + ": " +
                        frame.reason);
  for (std::size_t s = 0; s < d.data.sequences.size(); ++s) {
    std::vector<int> kept;
    for (int f = 0; f < static_cast<int>(d.data.sequences[s].frames.size()); ++f) {
      const bool is_dropped =
          std::any_of(record->dropped.begin(), record->dropped.end(), [&](const auto& frame) {
            return frame.sequence == d.data.sequences[s].name && frame.frame == f + 1;
          });
      if (!is_dropped) kept.push_back(f);
    }
    if (kept.size() < d.data.sequences[s].frames.size())
      estimation::keep_frames(d.data.sequences[s], kept);
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

/// Stiffnesses that the captures do not determine and that ran away: a sheet that resists nothing
/// in shear, or everything, comes to no rest in the next fit. Usual is the start value times what
/// the fit made of those that it determined; who fell far below is held there, who rose far above
/// is bounded, and whoever stayed may move by a factor from there on, or not at all where nothing
/// shows it: what is foretold of other captures would hang on where a refit happened to leave it.
/// `jacobian` of the fit; none, where that failed: then whoever ran away is held. Names of those
/// that ran.
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

/// The first fit of the baseline, with what ran away held.
Expected<FieldFit> first_fit(const model::Model& start, const model::Model& model,
                             const FieldFitOptions& options, SheetDiagnosis& d) {
  auto fit = fit_field(model, d.data, {}, options);
  model::Model held = fit ? fit->at.model : model;
  const std::vector<std::string> away =
      hold_undetermined(start, fit ? &fit->at.fit.jacobian : nullptr, held);
  if (away.empty()) {
    if (fit) fit->at.model = std::move(held);
    return fit;
  }
  auto again = fit_field(held, d.data, {}, options);
  if (!again) return fit;
  if (fit) {
    // what they did not determine is missed by no more than before
    constexpr double kShare = 0.02;
    const double missed = fit->at.fit.chi2 - static_cast<double>(fit->rows.size());
    if (again->at.fit.chi2 - fit->at.fit.chi2 > std::max(kDecisive, kShare * missed)) return fit;
  }
  for (const std::string& name : away)
    d.checklist.push_back({"WARNING",
                           "A stiffness that these captures do not determine is held or bounded",
                           name + " ran away from its start value"});
  return again;
}

/// What the baseline says of the captures that are held out; frames that have no rest with it are
/// left out by name, and a capture of which none has one is said to tell nothing.
Expected<void> foretell_held_out(const FieldFitOptions& options, SheetDiagnosis& d) {
  if (d.held_out.sequences.empty()) return {};
  const model::Model& model = d.baseline.at.model;
  FieldStates rests;
  for (estimation::Sequence& sequence : d.held_out.sequences) {
    auto rest = estimation::resting_frames(model, sequence, estimation::parameter_values(model),
                                           options.tolerance_N);
    if (!rest)
      return fail(rest.error().kind, "the captures that are held out: " + rest.error().message);
    if (rest->resting.empty())
      return bad_input("\"" + sequence.name + "\", which is held out, has no rest in any frame (" +
                       rest->restless.front().reason + ")");
    for (const estimation::RestlessFrame& frame : rest->restless)
      d.dropped.push_back(sequence.name + ", frame " + std::to_string(frame.frame + 1) + ": " +
                          frame.reason);
    estimation::keep_frames(sequence, rest->resting);
    rests.push_back(std::move(rest->states));
  }
  auto foretold = predict_field(model, d.held_out, rests, options);
  if (!foretold)
    return fail(foretold.error().kind,
                "the captures that are held out: " + foretold.error().message);
  const std::vector<Misread> misread =
      find_misread(d.held_out.sequences, foretold->rows, foretold->at.fit.residuals);
  set_aside(misread, d.held_out.sequences);
  if (!misread.empty()) foretold = predict_field(model, d.held_out, rests, options);
  if (!foretold) return tl::unexpected(foretold.error());
  d.held_out_baseline = std::move(*foretold);
  return {};
}

}  // namespace

FieldFitOptions field_options(const Control& control) {
  FieldFitOptions options;
  options.threads = control.threads;
  options.on_iteration = [&control](int, double) { return !control.stop.stop_requested(); };
  return options;
}

Expected<SheetDiagnosis> prepare_sheets(const SheetRequest& request, const Control& control) {
  SheetDiagnosis d;
  d.data = gathered(request, false);
  d.held_out = gathered(request, true);
  if (d.data.sequences.empty()) return bad_input("all captures are held out: none is left to fit");
  auto model = started(request, control, d);
  if (!model) return tl::unexpected(model.error());
  bring_back(request.model, *model);
  bound_bending(d.data, *model);
  FieldFitOptions options = field_options(control);
  options.on_iteration = [&](int iteration, double cost) {
    control.report({"baseline", request.model.name, iteration, cost, 0.06});
    return !control.stop.stop_requested();
  };
  auto fit = first_fit(request.model, *model, options, d);
  if (fit) {
    d.misread = find_misread(d.data.sequences, fit->rows, fit->at.fit.residuals);
    set_aside(d.misread, d.data.sequences);
    if (!d.misread.empty()) fit = fit_field(fit->at.model, d.data, fit->states, options);
  }
  // noise and fit depend on each other's weights: twice is enough
  for (int pass = 0; pass < 2 && fit; ++pass) {
    if (control.stop.stop_requested())
      return fail(ErrorKind::cancelled, "stopped before the baseline was fitted");
    const FieldNoise noise = estimate_field_noise(d.data, fit->rows, fit->at.fit.residuals);
    d.noise = pass == 0 ? noise : combined(d.noise, noise);
    const bool is_settled = std::all_of(noise.kinds.begin(), noise.kinds.end(),
                                        [](const auto& kind) { return kind.factor == 1.0; });
    if (is_settled) break;
    d.data = reweighed(d.data, noise);
    fit = fit_field(fit->at.model, d.data, fit->states, options);
  }
  if (!fit) return tl::unexpected(fit.error());
  d.baseline = std::move(*fit);
  auto excitation = examine_sheets(d.data, d.baseline.states);
  if (!excitation) return tl::unexpected(excitation.error());
  d.excitation = std::move(*excitation);
  if (auto ok = foretell_held_out(options, d); !ok) return tl::unexpected(ok.error());
  return d;
}

}  // namespace tenter::diagnosis
