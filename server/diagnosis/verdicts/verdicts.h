// SPDX-License-Identifier: GPL-3.0-or-later
// From findings to verdicts in words: named, ambiguous, sensor, not excited, unexplained (design,
// step 9).
#pragma once

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// An effect that passed every gate, with the other effects that were tried in its place.
struct Finding {
  Trial trial;
  std::vector<Trial> rivals;
};

/// Writes the verdicts and the checklist of `d`, whose fits and scores are done.
void pass_verdicts(Diagnosis& d, const std::vector<Finding>& findings, const Excitation& excitation,
                   const Options& options);

/// chi2 that the noise alone would leave: that of the null twins, or of neighbouring samples'
/// scatter where repeats differ by much more than that and so hide something that is no noise.
double noise_chi2(const Diagnosis& d);
/// Repeats differ smoothly by far more than neighbouring samples scatter.
bool irreproducible(const Diagnosis& d);
/// A fit to the data still misses more than the noise is thought to be.
bool misses_more_than_noise(const Diagnosis& d, const estimation::FitResult& last);
/// The same, and where nothing but neighbouring readings says how large the noise is, what is
/// missed goes on from one to the next.
bool lacks_fit_still(const Diagnosis& d, const estimation::FitResult& last);

}  // namespace tenter::diagnosis
