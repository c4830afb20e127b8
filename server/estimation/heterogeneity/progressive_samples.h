// SPDX-License-Identifier: GPL-3.0-or-later
// Material samples added one at a time where the residual asks for them, until the error on data
// that the fit did not see stops falling (thesis 4.4, the knee).
//
//   1. fit the homogeneous model
//   2. for every sample that is not released: how far would the cost fall if it were
//        gain_s = |proj of r onto the part of J_s that no free number can do|^2
//      J_s: derivative by the sample's own parameters, at the fit (a score test; no refit)
//   3. release the sample with the largest gain, fit again from the values at hand
//   4. keep it where the held-out cost falls by a share that counts and by more than its own
//      scatter; else put it back, and after `tries` refusals stop
//
// Where cloth folds, distances of points may say nothing (thesis 3.6): held-out rows that are not
// meaningful before or after a sample count neither way.
//
// The gradient of the cost by a local change of stiffness says where, the held-out data whether: a
// homogeneous sheet gets no sample. Cost: a fit a step, and one Jacobian over all samples.
//
//   auto found = add_samples(base, even_samples(4, 4, 0.1, 0.1), make_training, make_held_out);
//   for (const SampleStep& step : found->steps) ...   // kept: step.sample, at field.positions_m
//
// Deterministic. The factories are called with the model that evaluators are to be made of.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "server/estimation/heterogeneity/material_samples.h"

namespace tenter::estimation {

using MakeFor = std::function<Expected<std::unique_ptr<ResidualFunction>>(const model::Model&)>;

struct SampleOptions {
  FitOptions fit;
  int most = 16;              ///< samples that are released
  int tries = 2;              ///< refusals in a row, each of the next best sample, that end it
  double least_fall = 0.01;   ///< share of the held-out cost
  double least_sigmas = 2.0;  ///< of the fall over its scatter from row to row
  /// Which rows of the held-out data say something at its last evaluation, one each
  /// (sequences/folds/meaningful_rows.h). None: all.
  std::function<std::vector<bool>(const ResidualFunction&)> meaningful = nullptr;
};

struct SampleStep {
  int sample = -1;               ///< from 0
  double gain = 0.0;             ///< of the training cost, as the score test has it
  double training = 0.0;         ///< cost after the fit with it
  double held_out_before = 0.0;  ///< both over the rows that are meaningful before and after
  double held_out = 0.0;
  int rows_left_out = 0;  ///< of the held-out ones, that are not
  double sigmas = 0.0;    ///< the fall of the held-out cost over its scatter
  bool kept = false;
};

struct SampledFit {
  model::Model model;  ///< fitted: the base where no sample was kept, else with all samples
  FitResult fit;       ///< over the model's parameters
  std::vector<int> released;
  std::vector<SampleStep> steps;  ///< all that were tried, in order
  double training = 0.0;          ///< costs of `model`
  double held_out = 0.0;          ///< over the rows that are meaningful with and without samples
  double homogeneous_training = 0.0;
  double homogeneous_held_out = 0.0;
};

/// bad_input as with_samples(); also where the factories refuse, or the homogeneous fit has no
/// equilibrium.
Expected<SampledFit> add_samples(const model::Model& base, const MaterialSamples& samples,
                                 const MakeFor& training, const MakeFor& held_out,
                                 const SampleOptions& options = {});

}  // namespace tenter::estimation
