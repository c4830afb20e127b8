// SPDX-License-Identifier: GPL-3.0-or-later
// Where a fit of friction starts: the stages of the papers (thesis 5.3.2, 5.3.3), which keep it out
// of local minima.
//
//   1. k1, k2          without friction                     (left out where they are given)
//   2. a, b            at very small tau: sigma = s (a + b |eps|)
//   3. tau             alone, from the best of a row of values
//   4. all             eq. 5.6, of which the first three are the start
//
// 1 and 2 are linear and solved within the bounds; 3 looks at 60 values, from a thousandth of the
// largest strain between an anchor and a reading to three times that. Pure; any thread.
//
//   const AnchoredStart start = anchored_start(errors, friction_model("green_v"), nullptr);
//   FitResult found = fit(length_errors, with_values(model, start.stages.back()), {});
#pragma once

#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/friction_tests/anchored_errors.h"

namespace tenter::estimation {

struct AnchoredStart {
  std::vector<FrictionValues> stages;  ///< after 1 to 4
  std::vector<double> rms_load;        ///< error of the load after each (N/m; bending: N)
  FitResult papers;                    ///< of stage 4: the estimate of the papers
};

/// `stiffness`: k1 and k2 where another test gave them, null otherwise. The sigma of `errors` is
/// one load, as unit of rms_load.
AnchoredStart anchored_start(AnchoredErrors& errors, const model::Model& model,
                             const FrictionValues* stiffness);

/// The last stage, and the same with several values of tau: where tau is small beside the distance
/// of the readings, their noise may put the papers' tau so low that nothing moves with it any more.
std::vector<FrictionValues> starts_of(const AnchoredStart& start, const AnchoredErrors& anchored);

/// A fit of the path's own errors: a few steps from each start, then the whole from the best.
FitResult fit_from(const std::vector<FrictionValues>& starts, ResidualFunction& errors,
                   const model::Model& model, const FitOptions& options);

}  // namespace tenter::estimation
