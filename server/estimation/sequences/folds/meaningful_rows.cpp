// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/folds/meaningful_rows.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/sequences/folds/fold_comparison.h"

namespace tenter::estimation {

namespace {

/// Folds below so many standard deviations of a coordinate add little to distances, wherever they
/// lie.
constexpr double kHigh = 3.0;

double sigma_of(const Sequence& sequence) {
  double square = 0.0;
  for (const PointChannel& point : sequence.points)
    square += point.sigma_m * point.sigma_m / static_cast<double>(sequence.points.size());
  return std::sqrt(square);
}

bool says_something(const Sequence& sequence, std::size_t frame, const mechanics::State& state) {
  const auto folds = compare_folds(sequence, frame, state);
  if (!folds || is_meaningful(folds->positions)) return true;
  return std::max(folds->measured.height_m, folds->simulated.height_m) < kHigh * sigma_of(sequence);
}

}  // namespace

std::vector<bool> meaningful_rows(const SequenceEvaluator& evaluator) {
  const std::vector<Sequence>& sequences = evaluator.sequences();
  std::vector<std::vector<bool>> says(sequences.size());
  for (std::size_t s = 0; s < sequences.size(); ++s)
    for (std::size_t f = 0; f < sequences[s].frames.size(); ++f)
      says[s].push_back(says_something(sequences[s], f, evaluator.states()[s][f]));
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
