// SPDX-License-Identifier: GPL-3.0-or-later
// One candidate refitted to sheets, and whether it may be believed (design, step 7): what `trial.h`
// is to curves, with the same gates.
#pragma once

#include <array>
#include <string>

#include "server/diagnosis/field/data/field_fit.h"
#include "server/diagnosis/field/data/structure.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

struct FieldTrial {
  Trial trial;  ///< its fit `usable` where the refit went well
  FieldStates states;
};

/// From where `base` rests, with the amplitudes that the screen expects; where that leads too far,
/// once more from "off".
FieldTrial refit_field(const Candidate& candidate, const FieldFit& base, const FieldData& data,
                       const FieldFitOptions& options);

/// Rows that no fit sees, and how both models miss them.
struct HeldOutSheets {
  const FieldData* data = nullptr;  ///< null: there are none
  FieldFit before;                  ///< of the model that trials are compared with
};

/// Fills p_value, the held-out scores and the objections. What is left out: the sheets that are
/// held out where they speak for or against it; else protocols, captures or blocks in turn, the
/// first kind of which two folds can judge. An accident, which happens once, may come so late that
/// one block alone shows it: then frames.
void judge_field(FieldTrial& trial, const FieldFit& before, const FieldData& data,
                 const HeldOutSheets& held_out, double expected_chi2,
                 const FieldFitOptions& options);

/// What positions and all else say of a trial one by one; empty: nothing against it. `taken`: chi2
/// of each that was taken by effects whose form may miss something. The form of what was found by
/// positions says nothing of what forces miss; and what is right of the one makes the other no
/// worse. `is_more_of_one`: of an effect that is in already.
std::string objection_by_kind(const std::array<double, 2>& taken, const Misfit& before,
                              const Misfit& after, bool is_more_of_one);

/// The same of the grid's error, of which its estimate took `taken`.
std::string objection_of_grid(const std::array<double, 2>& taken, const Misfit& before,
                              const Misfit& after, const Variant& variant);

/// The folds that can judge what `larger` adds, of the first of these kinds that has two: the rest
/// determines it, and what is left out shows it. Fewer than two of any kind: empty.
estimation::Folds telling_folds(const FieldFit& larger, const FieldFit& smaller,
                                const FieldData& data,
                                const std::vector<std::string>& kinds = {"protocols", "captures",
                                                                         "blocks"});

}  // namespace tenter::diagnosis
