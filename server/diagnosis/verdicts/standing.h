// SPDX-License-Identifier: GPL-3.0-or-later
// Where a running diagnosis stands, in one line for whoever watches: the table of effects as the
// last screen filled it, and the best model so far.
//
//   "internal_friction 383, viscosity 121, 14 others below 1 x threshold; so far: none, error 5.0
//   %"
#pragma once

#include <string>
#include <vector>

#include "server/diagnosis/screen.h"

namespace tenter::diagnosis {

/// `added`: ids of the effects that were accepted; `error`: of the model with them, 0..1.
std::string standing(const Screen& screen, const std::vector<std::string>& added, double error);

}  // namespace tenter::diagnosis
