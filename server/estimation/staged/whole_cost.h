// SPDX-License-Identifier: GPL-3.0-or-later
// How far a model is from all sequences of a staged fit together, so that a stage that looked at
// its own sequences alone cannot ruin the others.
//
//   cost = sum over sequences  w_s / n_s  sum over n_s rows  r^2,     r in sigmas, w_s its weight
//
//   const WholeCost whole(measured, options);
//   auto before = whole.of(model), after = whole.of(changed);
//   if (after->is_above(*before)) ...          // the change is not taken
//
// A few frames of each sequence, walked from its start: a function of the model alone. Costs their
// equilibria. Pure; the same bytes for any number of threads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/estimation/staged/stage.h"

namespace tenter::estimation {

class WholeCost {
 public:
  struct Value {
    struct Part {
      double squares = 0.0;
      int rows = 0;
    };
    std::vector<double> weight;                          ///< [sequence]
    std::vector<std::vector<std::optional<Part>>> part;  ///< [sequence][frame]; none: no rest
    int restless() const;
    /// Over the frames that have a rest in both.
    double cost(const Value& other) const;
    /// More frames without a rest; or a higher cost, by more than 1 % and than noise explains (two
    /// standard deviations).
    bool is_above(const Value& before) const;
  };

  /// Of sequences that are not for evaluation, the channels that count. `options`: channels,
  /// threads, tolerance. `model`: as those that are asked for, but for their numbers.
  WholeCost(const model::Model& model, const std::vector<RoleSequence>& measured,
            const StageOptions& options);

  /// Errors as resting_frames().
  Expected<Value> of(const model::Model& model) const;

 private:
  std::vector<Sequence> sequences_;
  int threads_;
  double tolerance_N_;
};

}  // namespace tenter::estimation
