// SPDX-License-Identifier: GPL-3.0-or-later
// Which rows of sequences say something where cloth folds (thesis 3.6): positions of a frame whose
// measured and simulated folds lie elsewhere say nothing, however large their distances are.
//
//   if (evaluator.evaluate(p, r, nullptr) == PathStatus::ok)
//     auto says = meaningful_rows(evaluator);
//
// Forces always count, and so do frames of too few points to tell a fold, and those whose folds are
// lower than three standard deviations of a coordinate. A function of the last
// evaluation; costs the folds of each frame (fold_comparison.h). Pure.
#pragma once

#include <vector>

#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::estimation {

/// One a row. The last evaluation must have ended ok.
std::vector<bool> meaningful_rows(const SequenceEvaluator& evaluator);

}  // namespace tenter::estimation
