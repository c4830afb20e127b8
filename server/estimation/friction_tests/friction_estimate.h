// SPDX-License-Identifier: GPL-3.0-or-later
// What a test of internal friction found: k1, k2, a, b, tau, each with a 95 % interval from its
// profile likelihood, and a word in place of the number where the data do not tell it.
//
//   told          both ends of the interval exist, and lie within a factor of ten of each other
//                 where the parameter has to be positive
//   not told      one end or none exists (tau far below the distance of the readings: only an upper
//                 one), or the interval spans more than that, or a value beyond it fits as well, or
//                 the test does not look at it
//
// Why a number is not told is said behind it: what the readings lack, else that nothing moves with
// it, that only a combination with another number is told, or that zero does as well.
//
// Pure; the profiles take as many threads as they are given, with the same bytes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/estimation/friction_tests/anchored_start.h"
#include "server/estimation/uncertainty/profile.h"

namespace tenter::estimation {

struct FrictionNumber {
  std::string name;  ///< k1, k2, a, b, tau
  std::string unit;
  bool is_told = false;
  double value = 0.0;  ///< of the optimum; not to be printed where it is not told
  std::optional<double> lo;
  std::optional<double> hi;
  std::string words;  ///< "" where it is told; else why not, and what is known
};

/// What readings lack, so that a number may not be told.
struct ReadingsLack {
  std::vector<std::string> numbers;
  std::string words;
};

struct FrictionEstimate {
  model::Model model;   ///< with values and intervals
  FitResult fit;        ///< residuals in units of the noise
  AnchoredStart start;  ///< the papers' stages and their estimate
  std::vector<Profile> profiles;
  std::vector<FrictionNumber> numbers;
  std::vector<ReadingsLack> lacks;
  double noise = 0.0;        ///< standard deviation of a length; bending: of a point across (m)
  double gains_below = 0.0;  ///< strain below which a step may gain work (friction_model.h)
  int snapped = 0;           ///< steps in which the stress fell on the way to the next rest
};

struct FrictionFitOptions {
  int threads = 1;
  bool profiles = true;  ///< else intervals are those of the covariance, and cheaper
  FitOptions fit = {};
};

/// Fills model, profiles, numbers and gains_below of an estimate whose `fit` and `lacks` are there.
/// `make`: an evaluator of the rows of that fit.
void judge(const MakeFunction& make, const model::Model& start, const FrictionFitOptions& options,
           FrictionEstimate& estimate);

}  // namespace tenter::estimation
