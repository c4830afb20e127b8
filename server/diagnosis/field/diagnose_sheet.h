// SPDX-License-Identifier: GPL-3.0-or-later
// The chain on captures of a deforming sheet: what does the model get wrong, why, what would be
// right, how much better is it?
//
//   SheetRequest request{sequences, model, options};
//   auto d = diagnose_sheets(request, control);
//   for (const Verdict& v : d->verdicts) print(v.words);
//
// Steps are the functions of diagnose_sheet.cpp, in the order of design/diagnosis.md; the
// statistics are those of curves (screening/, trial.h). Pure: sequences and model in, findings out;
// the same bytes for any number of threads; progress and cancellation between solves. Cost: a fit,
// a screen (less than one more fit), and a refit for each of the best few candidates of a round.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "server/diagnosis/field/data/sheet_request.h"
#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/field/field_trial.h"
#include "server/diagnosis/field/noise/field_noise.h"
#include "server/diagnosis/field/noise/misread.h"
#include "server/diagnosis/screening/candidate.h"

namespace tenter::diagnosis {

/// Of one sequence: relative rms error of forces and rms error of positions.
struct SheetScore {
  Score before, after;  ///< over forces; of positions where there are none
  double points_before_m = 0.0, points_after_m = 0.0;  ///< rms of a coordinate
  double noise_floor = 0.0;                            ///< as `before`, of the noise alone
  bool held_out = false;
};

/// An effect whose columns correlate by more than 0.95 with those of one that was found.
struct LookAlike {
  std::string effect;
  double correlation = 0.0;  ///< canonical
  double told_apart = 0.0;   ///< chi2 by which the one explains more than the other can
  bool is_refitted = false;  ///< it is among the rivals: its refit says more than its columns
};

/// An effect that passed every gate, with the others that were tried in its place.
struct FieldFinding {
  Trial trial;
  Misfit before;  ///< of the model that it was added to
  std::vector<Trial> rivals;
  std::vector<LookAlike> look_alikes;
};

struct SheetDiagnosis : Findings {
  FieldData data;      ///< as fitted: without frames that have no rest, weighed by their noise
  FieldData held_out;  ///< sequences that no fit saw
  FieldNoise noise;
  std::vector<std::string> dropped;  ///< frames without rest, in words
  std::vector<Misread> misread;      ///< of `data`, set aside
  FieldFit baseline, extended;
  std::array<double, 2> taken_by_grid = {0.0, 0.0};  ///< chi2 of positions, of all else
  FieldFit held_out_baseline, held_out_extended;     ///< empty where nothing is held out
  Excitation excitation;
  std::vector<Structure> structure,
      structure_left;  ///< of the baseline's residuals, of what is left
  std::vector<FieldFinding> findings;
  std::vector<SheetScore> scores;  ///< of fitted sequences, then of those held out
};

/// bad_input for sequences or a model that cannot be fitted; cancelled.
Expected<SheetDiagnosis> diagnose_sheets(const SheetRequest& request, const Control& control);

}  // namespace tenter::diagnosis
