// SPDX-License-Identifier: GPL-3.0-or-later
// Psi_max of the model's energy limit and its elastic parameters, in alternation (thesis 4.4), over
// all fitted captures.
//
//   auto limited = sheet_limit(model, found, work);         // found.after: rests of `model`
//
// Where the data never reach the limit, its Psi_max in `model` is at least the largest density that
// they reach, and the message says what they say of it.
#pragma once

#include "server/jobs/sheet_fit/requests/requests.h"

namespace tenter::jobs {

struct LimitedModel {
  LimitFound found;
  std::optional<estimation::FitResult> optimum;  ///< with Psi_max unknown too
};

/// Of the first limit; the door lets only models with one in. `cancelled` where stopped. A limit
/// that cannot be fitted is no error but the message, and the model stays as it was.
Expected<LimitedModel> sheet_limit(model::Model& model, const SheetFindings& found,
                                   const RequestWork& work);

}  // namespace tenter::jobs
