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
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/refit/grid_free_fit.h"

namespace tenter::diagnosis {
namespace {

constexpr double kMost = 0.5;        // of what was missed: then the grid is to blame
constexpr double kWorthAWord = 0.1;  // of the noise's power

/// What was asked of a fitted sequence that comes with a finer one; none.
const SheetSequence* finer_of(const SheetRequest& request, const std::string& id) {
  for (const SheetSequence& s : request.sequences)
    if (s.id == id && !s.held_out && s.finer) return &s;
  return nullptr;
}

/// visit(row) of all but positions: what the grid's error is taken off.
template <class Visit>
void each_force(const FieldFit& fit, const FieldData& data, const Visit& visit) {
  std::vector<estimation::Observations> seen;
  for (const estimation::Sequence& sequence : data.sequences) seen.emplace_back(sequence);
  for (std::size_t r = 0; r < fit.rows.size(); ++r) {
    const auto s = static_cast<std::size_t>(fit.rows[r].curve);
    if (seen[s].kind(data.sequences[s], fit.rows[r].channel) !=
        estimation::ObservationKind::position)
      visit(static_cast<Eigen::Index>(r));
  }
}

double force_rows(const FieldFit& fit, const FieldData& data) {
  double rows = 0.0;
  each_force(fit, data, [&](Eigen::Index) { rows += 1.0; });
  return rows;
}

/// chi2 of forces beyond what noise has: positions are many, and keep the grid's error.
double missed_forces(const FieldFit& fit, const FieldData& data) {
  double missed = 0.0;
  const double noise = expected_chi2(fit) / static_cast<double>(fit.rows.size());
  each_force(fit, data, [&](Eigen::Index r) {
    missed += fit.at.fit.residuals[r] * fit.at.fit.residuals[r] - noise;
  });
  return missed;
}

Verdict numerical_verdict(double share, double missed, const FieldSize& size, double sigmas) {
  Verdict verdict;
  verdict.kind = VerdictKind::numerical;
  verdict.effect = "mesh_resolution";
  verdict.size = size.size;
  verdict.size_lo = size.lo;
  verdict.size_hi = size.hi;
  char words[280];
  std::snprintf(words, sizeof words,
                "The simulated grid accounts for %.0f %% of what the model missed of forces beyond "
                "the noise, %.1f %% of the %s: on a grid of half the spacing it misses that much "
                "less.",
                100.0 * share, 100.0 * size.size, size.of_force ? "force" : "motion of the points");
  verdict.words = words;
  if (const effects::Row* row = effects::find("mesh_resolution"))
    verdict.next_protocol = row->protocol;
  verdict.evidence = {{"share_of_the_misfit", share},
                      {"chi2_beyond_noise", missed},
                      {"grid_error_of_forces_in_sigmas", sigmas}};
  return verdict;
}

}  // namespace

Expected<void> check_grid(const SheetRequest& request, const Control& control, SheetDiagnosis& d) {
  FieldData free_of_grid = d.data;
  double sigmas = 0.0;
  bool has_any = false;
  for (std::size_t s = 0; s < d.data.sequences.size(); ++s) {
    const SheetSequence* asked = finer_of(request, d.data.ids[s]);
    // frames that were left out would have to be left out there too: such a capture stays as it is
    if (asked == nullptr || asked->finer->frames.size() != d.data.sequences[s].frames.size())
      continue;
    if (control.stop.stop_requested())
      return fail(ErrorKind::cancelled, "stopped while the grid was looked at");
    control.report({"grid", d.data.sequences[s].name, 0, d.baseline.at.fit.chi2, 0.08});
    estimation::Sequence coarse = d.data.sequences[s];
    for (std::size_t f = 0; f < coarse.frames.size(); ++f)
      coarse.frames[f].start = d.baseline.states[s][f];
    estimation::Sequence fine = *asked->finer;
    estimation::measure_as(coarse, fine);
    for (std::size_t f = 0; f < fine.frames.size(); ++f)
      fine.frames[f].duration_s = coarse.frames[f].duration_s;
    const auto error =
        estimation::grid_error(d.baseline.at.model, coarse, fine,
                               {.order = estimation::order_of(coarse, asked->is_laid_for_clips),
                                .threads = control.threads});
    if (!error) return tl::unexpected(error.error());
    const auto size = size_of(*error, coarse, estimation::ObservationKind::force);
    sigmas = std::max(sigmas, size.sigmas);
    free_of_grid.sequences[s] = without_grid_error(std::move(coarse), *error);
    has_any = true;
  }
  if (!has_any) return {};
  auto refitted =
      fit_field(d.baseline.at.model, free_of_grid, d.baseline.states, field_options(control));
  if (!refitted) return tl::unexpected(refitted.error());
  const double missed = missed_forces(d.baseline, d.data);
  const double left = std::max(0.0, missed_forces(*refitted, free_of_grid));
  const double share = missed > 0.0 ? std::clamp(1.0 - left / missed, 0.0, 1.0) : 0.0;
  char why[140];
  std::snprintf(why, sizeof why,
                "its error is up to %.2g standard deviations of a force; without it the model "
                "misses %.0f %% less of forces",
                sigmas, 100.0 * share);
  const bool is_to_blame = share >= kMost && missed > kWorthAWord * force_rows(d.baseline, d.data);
  d.checklist.push_back({is_to_blame ? "WARNING" : "OK",
                         "The simulated grid was compared with one of half its spacing", why});
  if (is_to_blame && refitted->rows.size() == d.baseline.rows.size())
    d.verdicts.push_back(numerical_verdict(
        share, missed,
        size_between(d.data, d.baseline.rows, d.baseline.at.fit.residuals,
                     refitted->at.fit.residuals, d.data.block_count(), request.options.seed),
        sigmas));
  d.data = std::move(free_of_grid);
  d.baseline = std::move(*refitted);
  return {};
}

}  // namespace tenter::diagnosis
