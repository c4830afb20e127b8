// SPDX-License-Identifier: GPL-3.0-or-later
// How much better is the extended model on data that its fit never saw?
//
// Protocols, repeats or runs (the first kind of which there are enough) are left out in turn, both
// models are fitted to the rest, and what was left out is predicted.
#pragma once

#include <string>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// Fills the scores of baseline and extended model, in sample and held out, in all and per capture.
void measure_gain(Diagnosis& d, const Options& options, const Control& control);

/// Does another optimum of the same model predict left-out data no worse? Judged by chi2 over the
/// left-out rows; yes where nothing can be left out. `leave_out` as in Options.
bool predicts_as_well(const Reference& other, const Reference& current, const Reference& baseline,
                      const DataPointer& data, const std::string& leave_out);

}  // namespace tenter::diagnosis
