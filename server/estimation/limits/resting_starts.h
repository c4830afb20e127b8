// SPDX-License-Identifier: GPL-3.0-or-later
// Sequences whose frames start where an evaluator brought them to rest, free clips included: from
// far away a frame may come to rest in other folds, whose cost says nothing of what was changed.
//
//   auto next = SequenceEvaluator::make(changed_model, started_from_rest(evaluator), options);
//
// The last evaluation must have ended ok.
#pragma once

#include <vector>

#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::estimation {

std::vector<Sequence> started_from_rest(const SequenceEvaluator& evaluator);

}  // namespace tenter::estimation
