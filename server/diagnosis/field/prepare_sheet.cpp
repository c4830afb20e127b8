// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/prepare_sheet.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/diagnosis/field/data/start.h"
#include "server/diagnosis/field/screen/field_excitation.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"

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

/// Most of the forces are missed: no model of cloth is as wrong as that, but a fit may have gone
/// where a sheet wrinkles.
bool misses_most(const FieldFit& fit, const FieldData& data) {
  constexpr double kMost = 0.3;
  double missed = 0.0, measured = 0.0;
  for (std::size_t r = 0; r < fit.rows.size(); ++r) {
    const estimation::Row& row = fit.rows[r];
    const estimation::Sequence& sequence = data.sequences[static_cast<std::size_t>(row.curve)];
    const estimation::Observations channels(sequence);
    if (channels.kind(sequence, row.channel) != estimation::ObservationKind::force) continue;
    const auto& frame = sequence.frames[static_cast<std::size_t>(row.frame)];
    missed += std::pow(
        fit.at.fit.residuals[static_cast<Eigen::Index>(r)] * channels.sigma(sequence, row.channel),
        2);
    measured += std::pow(channels.measured(frame, row.channel), 2);
  }
  return missed > kMost * kMost * measured;
}

/// The same from a start that forces scaled, where the fit misses most of them; the better one.
void try_other_start(const model::Model& start, const FieldFitOptions& options, SheetDiagnosis& d,
                     FieldFit& fit) {
  if (!misses_most(fit, d.data)) return;
  const auto scaled = scaled_to_forces(start, d.data);
  if (!scaled) return;
  const std::vector<Check> said = d.checklist;
  auto again = first_fit(start, *scaled, options, d);
  if (again && again->at.fit.chi2 < fit.at.fit.chi2)
    fit = std::move(*again);
  else
    d.checklist = said;
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
  auto model = find_start(request.model, control, d.data, d.dropped);
  if (!model) return tl::unexpected(model.error());
  FieldFitOptions options = field_options(control);
  options.on_iteration = [&](int iteration, double cost) {
    control.report({"baseline", request.model.name, iteration, cost, 0.06});
    return !control.stop.stop_requested();
  };
  auto fit = first_fit(request.model, *model, options, d);
  if (fit) {
    try_other_start(request.model, options, d, *fit);
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
