// SPDX-License-Identifier: GPL-3.0-or-later
// Where in the material stiffness differs: samples added one at a time where the residual asks for
// it, until the error on the held-out captures stops falling (thesis 4.4).
//
//   auto samples = sheet_samples(model, found, work);       // found.after: rests of `model`
//
// Samples lie on an even kGrid x kGrid grid over the sheet, with all terms of the model at each; at
// most found.options.samples of them get numbers of their own. Frames of held-out captures that are
// folded otherwise than the simulated sheet do not count where their distances say nothing. Of each
// capture at most kSampleFrames frames are compared. Where no sample is kept the model stays as it
// was.
#pragma once

#include "server/jobs/sheet_fit/requests/requests.h"

namespace tenter::jobs {

inline constexpr int kGrid = 4;
inline constexpr int kSampleFrames = 8;  ///< of a capture: a Jacobian has sixteen times the columns

struct SampledModel {
  SamplesFound found;
  std::optional<estimation::FitResult> optimum;  ///< of the model with samples
};

/// `cancelled` where stopped. That samples cannot be added is no error but the message.
Expected<SampledModel> sheet_samples(model::Model& model, const SheetFindings& found,
                                     const RequestWork& work);

}  // namespace tenter::jobs
