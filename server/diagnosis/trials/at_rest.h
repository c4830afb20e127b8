// SPDX-License-Identifier: GPL-3.0-or-later
// A specimen that was never pulled bears nothing where it rests, whatever it is made of: there a
// load cell shows its own offset, and one that is not seen there is something else.
#pragma once

#include <string>

#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// Why the offsets that a trial adds are none; empty: nothing against them, or no reading at rest.
/// `trial` has been fitted to `data`.
std::string objection_at_rest(const Trial& trial, const DataPointer& data);

}  // namespace tenter::diagnosis
