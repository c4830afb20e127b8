// SPDX-License-Identifier: GPL-3.0-or-later
// From findings to verdicts in words: named, ambiguous, sensor, not excited, unexplained (design, step 9).
#pragma once

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// An effect that passed every gate, with the other effects that were tried in its place.
struct Finding {
  Trial trial;
  std::vector<Trial> rivals;
};

/// Writes the verdicts and the checklist of `d`, whose fits and scores are done.
void pass_verdicts(Diagnosis& d, const std::vector<Finding>& findings, const Excitation& excitation,
                   unsigned long long seed);

const char* verdict_name(VerdictKind kind);

}  // namespace tenter::diagnosis
