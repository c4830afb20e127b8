// SPDX-License-Identifier: GPL-3.0-or-later
// One sense of curvature after its fit: what figures, tables and documents are made from.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/estimation/friction_tests/bending/bending_fit.h"
#include "server/jobs/friction_test/strips/strips_of_captures.h"

namespace tenter::jobs {

/// What was read of one sample, and what the model makes of it.
struct SampleOfStrip {
  const estimation::ProfileSamples* profile = nullptr;
  const estimation::TorqueSample* read = nullptr;
  double strain =
      0.0;  ///< of the model under the torque of the weight (1/m); NaN of cantilevers alone
  double torque = 0.0;  ///< of the model at the strain that was read (N)
};

struct StripPart {
  std::string sense;  ///< "positive", "negative"
  estimation::BendingTests tests;
  estimation::BendingEstimate found;

  /// Of every sample, in the order of found.profiles.
  std::vector<SampleOfStrip> samples;
};

/// Fills `samples`. The part has to stay where it is for as long as they are looked at.
void look_at_samples(StripPart& part);

/// Root mean square over the samples of all parts, of what `value` gives.
double rms_of_samples(const std::vector<StripPart>& parts,
                      const std::function<double(const SampleOfStrip&)>& value);

}  // namespace tenter::jobs
