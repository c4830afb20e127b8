// SPDX-License-Identifier: GPL-3.0-or-later
// A model whose terms differ over the material (thesis 4.2.4, 4.4): energies at samples, with
// normalised Gaussians between them,
//
//   Psi(X) = sum_k w_k(X) Psi_k,    sum_k w_k = 1
//
// With equal parameters at all samples it is the homogeneous model, to rounding. So heterogeneity
// can grow in steps that contain each other: of all samples only the released ones have numbers of
// their own, the others share the background's.
//
//   auto model = with_samples(base, samples).value();
//   auto ties = background_ties(model, base, samples, {7});     // sample 7, from 0, is released
//   FitResult found = fit_tied(evaluator, *ties, {});
//
// Values and pure functions.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/staged/parameter_ties.h"

namespace tenter::estimation {

struct MaterialSamples {
  model::Field field;              ///< positions and width; its id becomes the model's field
  std::vector<std::string> terms;  ///< of the base model, that may differ; empty: all
};

/// Even samples of a sheet of `length_u_m` x `length_v_m` from (0, 0), in the middle of count_u x
/// count_v equal fields; the width is half of the larger distance of neighbours.
MaterialSamples even_samples(int count_u, int count_v, double length_u_m, double length_v_m);

/// Each named term becomes one for each sample, "weft" becomes "weft_1", "weft_2", ...; the others
/// stay. bad_input: a term that is not there or acts at samples already, a limit on one, or a field
/// without samples or width.
Expected<model::Model> with_samples(const model::Model& base, const MaterialSamples& samples);

/// Shared numbers of all samples that are not in `released` (indices from 0).
Expected<ParameterTies> background_ties(const model::Model& expanded, const model::Model& base,
                                        const MaterialSamples& samples,
                                        const std::vector<int>& released);

/// Flat parameters of the expanded model that belong to one sample.
std::vector<int> parameters_of_sample(const model::Model& expanded, int sample);

}  // namespace tenter::estimation
