// SPDX-License-Identifier: GPL-3.0-or-later
// Do the intervals of a fit hold the truth as often as they say?
//
// The same noise-free sequences get the rig's noise of many seeds; each is fitted from a poor start
// by noise weights, and every parameter's 95 % interval either holds the true value or does not.
//
//   const Fabric wool = reached_everywhere(fabric("18"));
//   Coverage result = coverage_of(wool, {.seeds = 200, .threads = 2});
//   const auto [fewest, most] = binomial_band(200, 0.95);      // 179 to 198
//
// Seeds are fitted in parallel; the same numbers for any number of threads.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"
#include "tests/twin/fabrics/fabric.h"

namespace tenter::twin {

struct CoverageOptions {
  int seeds = 200;
  int threads = 1;
  int frames = 12;  ///< of each sequence
  int cells = 6;
};

struct ParameterCoverage {
  std::string name;  ///< "term.parameter"
  double truth = 0.0;
  int held = 0;                 ///< seeds whose interval holds the truth
  int at_bound = 0;             ///< seeds without an interval: not held
  double mean_off = 0.0;        ///< mean of (fitted - truth) / standard error
  double spread = 0.0;          ///< standard deviation of that
  double relative_error = 0.0;  ///< mean standard error over the truth
};

struct Coverage {
  int restarted = 0;             ///< fits that ended off the noise floor and were begun again
  int usable = 0;                ///< fits that ended with intervals
  double chi2_per_degree = 0.0;  ///< mean
  std::vector<ParameterCoverage> parameters;
};

/// Curves whose every control point the sequences reach: stretch as it is, the others constant.
Fabric reached_everywhere(Fabric fabric);

/// The five sequences for fits on a grid of `cells` cells, without noise.
std::vector<estimation::Sequence> fitting_sequences(const Fabric& fabric, int frames, int cells);

/// Every parameter 30 to 50 % off, each term its own way.
model::Model poor_start(model::Model truth);

Coverage coverage_of(const Fabric& fabric, const CoverageOptions& options);

/// Fewest and most successes of `trials` that leave out at most `tail` on either side.
std::pair<int, int> binomial_band(int trials, double probability, double tail = 5e-4);

}  // namespace tenter::twin
