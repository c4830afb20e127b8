// SPDX-License-Identifier: GPL-3.0-or-later
// Steps of the path of additions, and why a step is taken back; of curves and of sheets.
#pragma once

#include <string>

#include "server/diagnosis/findings.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// `error`: of the model at `at`, as a Score has it.
PathStep path_step(const std::string& action, const std::string& effect, const std::string& why,
                   const Reference& at, double error);

/// Why an effect may go that the model `whole` has and its refit `reduced` has not: the F test no
/// longer asks for it. "" where it does.
std::string made_needless(const Reference& reduced, const Reference& whole);

/// Why an effect gives way to its plain form.
inline constexpr const char* kPlainIsEnough =
    "what is its own is not surely there any more: its plain form is enough";

/// Why an effect may go whose best part explained `share` of what was missed beyond the noise when
/// it came in, where the model still misses the share `left` of what the baseline missed: it stands
/// in for something that the catalogue lacks. "" where it explained enough. `is_exact`: alone, its
/// form would leave nothing.
std::string stands_in(double share, double left, bool is_exact = false);

/// Whether so many different effects, of which the first explained `first_share` of what all of
/// them explain, are terms of a series rather than causes: of one or two causes the larger explains
/// more, and what is left is the other's.
bool is_a_series(int effects, double first_share);

}  // namespace tenter::diagnosis
