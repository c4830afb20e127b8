// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/start/multi_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include "server/estimation/parallel.h"

namespace tenter::estimation {
namespace {

StartOutcome outcome_of(SequenceEvaluator& evaluator, const model::Model& model, ParameterTies ties,
                        const std::vector<Sequence>& sequences, const Eigen::VectorXd& start,
                        const MultiStartOptions& options) {
  const auto put = [&](const Eigen::VectorXd& q) {
    for (std::size_t k = 0; k < ties.free.size(); ++k)
      ties.free[k].value = q[static_cast<Eigen::Index>(k)];
  };
  StartOutcome outcome;
  put(start);
  if (options.guess) {
    std::vector<GapSequence> measured;
    measured.reserve(sequences.size());
    for (const Sequence& s : sequences) measured.push_back({&s, GapRows::all});
    const auto gap = equation_gap(model, ties, measured, options.gap);
    if (gap)
      put(gap->q);
    else
      outcome.message = "no guess: " + gap.error().message + "; ";
  }
  FitResult result = fit_tied(evaluator, ties, options.fit);
  outcome.usable = result.usable;
  outcome.cost = result.usable ? result.chi2 : std::numeric_limits<double>::infinity();
  outcome.parameters = std::move(result.parameters);
  outcome.iterations = result.iterations;
  outcome.message += result.message;
  return outcome;
}

}  // namespace

std::vector<Eigen::VectorXd> random_starts(const ParameterTies& ties, int count, double widest,
                                           std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::VectorXd> starts;
  for (int k = 0; k < count; ++k) {
    Eigen::VectorXd q = ties.values();
    for (std::size_t i = 0; i < ties.free.size(); ++i) {
      // even in [-1, 1), the same on every platform
      const double even = static_cast<double>(random() >> 11U) * 0x1p-52 - 1.0;
      const model::Parameter& p = ties.free[i];
      if (p.fixed) continue;
      double& value = q[static_cast<Eigen::Index>(i)];
      value *= std::pow(widest, even);
      if (p.lower) value = std::max(value, *p.lower);
      if (p.upper) value = std::min(value, *p.upper);
    }
    starts.push_back(std::move(q));
  }
  return starts;
}

Expected<std::vector<StartOutcome>> multi_start(const model::Model& model,
                                                const ParameterTies& ties,
                                                const std::vector<Sequence>& sequences,
                                                const std::vector<Eigen::VectorXd>& starts,
                                                const MultiStartOptions& options) {
  if (auto ok = without_corrections(model); !ok) return tl::unexpected(ok.error());
  SequenceOptions evaluating;
  evaluating.tolerance_N = options.tolerance_N;
  evaluating.weighting = options.weighting;
  if (auto made = SequenceEvaluator::make(model, sequences, evaluating); !made)
    return tl::unexpected(made.error());
  std::vector<StartOutcome> outcomes(starts.size());
  in_parallel(options.threads, static_cast<int>(starts.size()), [&](int, int k) {
    const auto i = static_cast<std::size_t>(k);
    // one that has seen nothing: what it remembers is part of the answer
    auto evaluator = SequenceEvaluator::make(model, sequences, evaluating);
    outcomes[i] = outcome_of(*evaluator, model, ties, sequences, starts[i], options);
    outcomes[i].start = k;
  });
  std::stable_sort(outcomes.begin(), outcomes.end(),
                   [](const StartOutcome& a, const StartOutcome& b) { return a.cost < b.cost; });
  return outcomes;
}

int in_best_basin(const std::vector<StartOutcome>& outcomes, double share) {
  if (outcomes.empty() || !outcomes.front().usable) return 0;
  return static_cast<int>(
      std::count_if(outcomes.begin(), outcomes.end(), [&](const StartOutcome& o) {
        return o.usable && o.cost <= (1.0 + share) * outcomes.front().cost;
      }));
}

}  // namespace tenter::estimation
