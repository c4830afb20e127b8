// SPDX-License-Identifier: GPL-3.0-or-later
// The same fit from many starts: how often each reaches the best basin. The costs in their order
// are the waterfall.
//
//   const auto starts = random_starts(ties, 20, 10.0, seed);
//   auto outcomes = multi_start(model, ties, sequences, starts, options);
//   for (const StartOutcome& o : *outcomes) ... o.cost               // lowest first
//
// Each start has an evaluator of its own, so outcomes are the same for any number of threads, to
// the byte. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/start/equation_gap.h"

namespace tenter::estimation {

struct MultiStartOptions {
  int threads = 1;
  FitOptions fit;
  double tolerance_N = 1e-7;
  Weighting weighting = {};
  bool guess = false;  ///< put the equation gap between start and fit
  GapOptions gap;
};

struct StartOutcome {
  int start = 0;        ///< its place among the starts
  bool usable = false;  ///< else `cost` is infinite
  double cost = 0.0;
  Eigen::VectorXd parameters;  ///< of the model
  int iterations = 0;
  std::string message;
};

/// The values of `ties.free`, each times a factor even in its logarithm between 1/widest and
/// widest; what is fixed stays. Within bounds.
std::vector<Eigen::VectorXd> random_starts(const ParameterTies& ties, int count, double widest,
                                           std::uint64_t seed);

/// Sorted by cost, then by place. Errors as SequenceEvaluator::make(). Where a guess cannot be made
/// the fit begins at the start itself, and the message says so.
Expected<std::vector<StartOutcome>> multi_start(const model::Model& model,
                                                const ParameterTies& ties,
                                                const std::vector<Sequence>& sequences,
                                                const std::vector<Eigen::VectorXd>& starts,
                                                const MultiStartOptions& options);

/// Outcomes whose cost is within `share` of the lowest.
int in_best_basin(const std::vector<StartOutcome>& outcomes, double share);

}  // namespace tenter::estimation
