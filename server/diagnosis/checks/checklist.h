// SPDX-License-Identifier: GPL-3.0-or-later
// What a reader must know before trusting the numbers: nothing is silent (design: frozen,
// zero-gradient, at-bound parameters and dropped frames are in the report).
#pragma once

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// Fills the checklist from the fits, the noise and the captures.
void check(Diagnosis& d);

}  // namespace tenter::diagnosis
