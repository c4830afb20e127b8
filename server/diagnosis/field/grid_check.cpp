// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/grid_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "server/diagnosis/field/field_gain.h"
#include "server/diagnosis/field/prepare_sheet.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "server/estimation/sequences/discretisation/grid_error.h"
#include "server/estimation/staged/refit/grid_free_fit.h"

namespace tenter::diagnosis {
namespace {

constexpr double kMost = 0.5;        // of what was missed: then the grid is to blame
constexpr double kWorthAWord = 0.1;  // of the noise's power

/// What was asked of a sequence that comes with a finer one; none.
const SheetSequence* finer_of(const SheetRequest& request, const std::string& id, bool held_out) {
  for (const SheetSequence& s : request.sequences)
    if (s.id == id && s.held_out == held_out && s.finer) return &s;
  return nullptr;
}

/// Takes the grid's error off those sequences of `data` that come with finer ones, which rest in
/// `states`; false where there are none. `sigmas`: the largest error of forces.
Expected<bool> take_off(const SheetRequest& request, const Control& control, bool held_out,
                        const model::Model& model, const FieldStates& states, FieldData& data,
                        double& sigmas) {
  bool has_any = false;
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    const SheetSequence* asked = finer_of(request, data.ids[s], held_out);
    // frames that were left out would have to be left out there too: such a capture stays as it is
    if (asked == nullptr || asked->finer->frames.size() != data.sequences[s].frames.size())
      continue;
    if (control.stop.stop_requested())
      return fail(ErrorKind::cancelled, "stopped while the grid was looked at");
    control.report({"grid", data.sequences[s].name, 0, 0.0, 0.08});
    estimation::Sequence coarse = data.sequences[s];
    for (std::size_t f = 0; f < coarse.frames.size(); ++f) coarse.frames[f].start = states[s][f];
    estimation::Sequence fine = *asked->finer;
    estimation::measure_as(coarse, fine);
    // the noise that was found, too: channels of both grids weigh alike
    fine.points = coarse.points;
    fine.forces = coarse.forces;
    fine.scalars = coarse.scalars;
    for (std::size_t f = 0; f < fine.frames.size(); ++f)
      fine.frames[f].duration_s = coarse.frames[f].duration_s;
    const auto error =
        estimation::grid_error(model, coarse, fine,
                               {.order = estimation::order_of(coarse, asked->is_laid_for_clips),
                                .of_positions = true,
                                .threads = control.threads});
    if (!error) return tl::unexpected(error.error());
    const auto size = size_of(*error, coarse, estimation::ObservationKind::force);
    sigmas = std::max(sigmas, size.sigmas);
    data.sequences[s] = without_grid_error(std::move(coarse), *error);
    has_any = true;
  }
  return has_any;
}

Verdict numerical_verdict(double share, double missed, const SizeInterval& size, double sigmas) {
  Verdict verdict;
  verdict.kind = VerdictKind::numerical;
  verdict.effect = "mesh_resolution";
  verdict.size = size.size;
  verdict.size_lo = size.lo;
  verdict.size_hi = size.hi;
  char words[240];
  std::snprintf(words, sizeof words,
                "The simulated grid accounts for %.0f %% of what the model missed beyond the "
                "noise, %.1f %% of the %s: on a grid of half the spacing it misses that much less.",
                100.0 * share, 100.0 * size.size, size.of_force ? "force" : "motion of the points");
  verdict.words = words;
  if (const effects::Row* row = effects::find("mesh_resolution"))
    verdict.next_protocol = row->protocol;
  verdict.evidence = {{"share_of_the_misfit", share},
                      {"chi2_beyond_noise", missed},
                      {"grid_error_of_forces_in_sigmas", sigmas}};
  return verdict;
}

/// chi2 of positions, of all else.
std::array<double, 2> chi2_by_kind(const FieldData& data, const FieldFit& at) {
  return misfit_of(data.sequences, at.rows, at.at.fit.residuals).chi2;
}

/// By how much readings of positions, and all else, differ: chi2.
std::array<double, 2> apart_by_kind(const FieldData& data, const FieldData& other) {
  std::array<double, 2> chi2 = {0.0, 0.0};
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    const estimation::Sequence& sequence = data.sequences[s];
    const estimation::Observations channels(sequence);
    for (std::size_t f = 0; f < sequence.frames.size(); ++f)
      for (int c = 0; c < channels.count(); ++c) {
        const double apart = (channels.measured(sequence.frames[f], c) -
                              channels.measured(other.sequences[s].frames[f], c)) /
                             channels.sigma(sequence, c);
        const bool is_position =
            channels.kind(sequence, c) == estimation::ObservationKind::position;
        if (std::isfinite(apart)) chi2[is_position ? 0 : 1] += apart * apart;
      }
  }
  return chi2;
}

/// Of positions or of all else, more than the noise.
bool misses_something(const SheetDiagnosis& d) {
  constexpr double kLeast = 1.1;
  const Misfit misfit = misfit_of(d.data.sequences, d.baseline.rows, d.baseline.at.fit.residuals);
  const double noise = expected_chi2(d.baseline) / static_cast<double>(d.baseline.rows.size());
  for (const std::size_t kind : {0UL, 1UL})
    if (misfit.chi2[kind] > kLeast * noise * misfit.rows[kind]) return true;
  return false;
}

/// Sequences that are missed by more without the grid's error keep it; how many.
int put_back_worse(SheetDiagnosis& d, const FieldFit& without, FieldData& free_of_grid) {
  const auto by_sequence = [&](const FieldFit& fit) {
    std::vector<double> chi2(d.data.sequences.size(), 0.0);
    for (std::size_t r = 0; r < fit.rows.size(); ++r)
      chi2[static_cast<std::size_t>(fit.rows[r].curve)] +=
          std::pow(fit.at.fit.residuals[static_cast<Eigen::Index>(r)], 2);
    return chi2;
  };
  const std::vector<double> before = by_sequence(d.baseline), after = by_sequence(without);
  const auto with_all = chi2_by_kind(d.data, d.baseline);
  const auto without_all = chi2_by_kind(free_of_grid, without);
  int worse = 0;
  for (std::size_t s = 0; s < before.size(); ++s) {
    if (after[s] <= before[s] + kDecisive) continue;
    free_of_grid.sequences[s] = d.data.sequences[s];
    ++worse;
  }
  // how far the grids differ there is as far as nobody knows
  for (const std::size_t kind : {0UL, 1UL})
    if (worse > 0) d.taken_by_grid[kind] = std::max(0.0, without_all[kind] - with_all[kind]);
  return worse;
}

/// How far the grid's error went, and with which baseline after it.
Expected<void> compare_grids(const SheetRequest& request, const Control& control,
                             SheetDiagnosis& d) {
  FieldData free_of_grid = d.data;
  double sigmas = 0.0;
  const auto has_any = take_off(request, control, false, d.baseline.at.model, d.baseline.states,
                                free_of_grid, sigmas);
  if (!has_any) return tl::unexpected(has_any.error());
  if (!*has_any) return {};
  auto refitted =
      fit_field(d.baseline.at.model, free_of_grid, d.baseline.states, field_options(control));
  if (!refitted) return tl::unexpected(refitted.error());
  const std::array<double, 2> apart = apart_by_kind(d.data, free_of_grid);
  if (const int worse = put_back_worse(d, *refitted, free_of_grid); worse > 0) {
    d.checklist.push_back(
        {"WARNING", "A finer grid is no better for some captures",
         std::to_string(worse) + " of " + std::to_string(d.data.sequences.size()) +
             " would be missed by more without the estimate of its error, as where "
             "only one of the grids wrinkles: they stay as they were read"});
    refitted =
        fit_field(d.baseline.at.model, free_of_grid, d.baseline.states, field_options(control));
    if (!refitted) return tl::unexpected(refitted.error());
  }
  const double missed = d.baseline.at.fit.chi2 - expected_chi2(d.baseline);
  const double left = std::max(0.0, refitted->at.fit.chi2 - expected_chi2(*refitted));
  const double share = missed > 0.0 ? std::clamp(1.0 - left / missed, 0.0, 1.0) : 0.0;
  char why[120];
  std::snprintf(why, sizeof why,
                "its error is up to %.2g standard deviations of a force; without it the model "
                "misses %.0f %% less",
                sigmas, 100.0 * share);
  const bool is_to_blame =
      share >= kMost && missed > kWorthAWord * static_cast<double>(d.baseline.rows.size());
  d.checklist.push_back({is_to_blame ? "WARNING" : "OK",
                         "The simulated grid was compared with one of half its spacing", why});
  if (is_to_blame && refitted->rows.size() == d.baseline.rows.size())
    d.verdicts.push_back(numerical_verdict(
        share, missed, sheet_effect_size(d.data, d.baseline, *refitted, request.options.seed),
        sigmas));
  if (refitted->rows.size() == d.baseline.rows.size()) {
    const auto with = chi2_by_kind(d.data, d.baseline);
    const auto without = chi2_by_kind(free_of_grid, *refitted);
    // of a misfit that is another's it may take more than it is, by chance
    for (const std::size_t kind : {0UL, 1UL})
      d.taken_by_grid[kind] =
          std::min(apart[kind], d.taken_by_grid[kind] + std::max(0.0, with[kind] - without[kind]));
  }
  d.data = std::move(free_of_grid);
  d.baseline = std::move(*refitted);
  if (d.held_out.sequences.empty()) return {};
  // what no fit saw is judged by the same baseline, on readings without the grid's error, too
  double of_held_out = 0.0;
  const auto has_held_out = take_off(request, control, true, d.baseline.at.model,
                                     d.held_out_baseline.states, d.held_out, of_held_out);
  if (!has_held_out) return tl::unexpected(has_held_out.error());
  auto foretold = predict_field(d.baseline.at.model, d.held_out, d.held_out_baseline.states,
                                field_options(control));
  if (!foretold) return tl::unexpected(foretold.error());
  d.held_out_baseline = std::move(*foretold);
  return {};
}

}  // namespace

Expected<void> check_grid(const SheetRequest& request, const Control& control, SheetDiagnosis& d) {
  if (!misses_something(d)) return {};
  SheetDiagnosis changed = d;  // as it was, if any of it fails
  auto compared = compare_grids(request, control, changed);
  if (compared) d = std::move(changed);
  if (compared || compared.error().kind == ErrorKind::cancelled) return compared;
  d.checklist.push_back({"WARNING", "The simulated grid was not compared with a finer one",
                         compared.error().message});
  return {};
}

}  // namespace tenter::diagnosis
