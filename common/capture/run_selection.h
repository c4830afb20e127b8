// SPDX-License-Identifier: Apache-2.0
// Some runs of a capture as a capture of their own: pulls that a fit sees and pulls that are held
// out come from one file.
//
//   auto fitted = with_runs(capture, {2, 3, 4});      // numbers as in the source, in any order
//
// All that is over frames is cut, and the title says which runs are left; the rest stays, and so do
// places in the material that were read from all runs. Linear in what the capture holds.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

/// bad_input names a run that is not there, and those that are.
Expected<Capture> with_runs(Capture capture, const std::vector<int>& numbers);

}  // namespace tenter::capture
