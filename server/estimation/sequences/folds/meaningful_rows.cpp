// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/folds/meaningful_rows.h"

#include "server/estimation/sequences/folds/fold_comparison.h"

namespace tenter::estimation {

std::vector<bool> meaningful_rows(const SequenceEvaluator& evaluator) {
  const std::vector<Sequence>& sequences = evaluator.sequences();
  std::vector<std::vector<bool>> says(sequences.size());
  for (std::size_t s = 0; s < sequences.size(); ++s)
    for (std::size_t f = 0; f < sequences[s].frames.size(); ++f) {
      const auto folds = compare_folds(sequences[s], f, evaluator.states()[s][f]);
      says[s].push_back(!folds || is_meaningful(folds->positions));
    }
  std::vector<bool> rows;
  rows.reserve(evaluator.rows().size());
  for (const Row& row : evaluator.rows()) {
    const auto s = static_cast<std::size_t>(row.curve);
    const bool is_position = row.channel < static_cast<int>(3 * sequences[s].points.size());
    rows.push_back(!is_position || says[s][static_cast<std::size_t>(row.frame)]);
  }
  return rows;
}

}  // namespace tenter::estimation
