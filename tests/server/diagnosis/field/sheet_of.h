// SPDX-License-Identifier: GPL-3.0-or-later
// Small sheets with a hidden truth, as a diagnosis takes them: the truth walked along a protocol on
// the fit's own grid, and the rig's noise.
#pragma once

#include <string>
#include <vector>

#include "server/diagnosis/field/data/sheet_request.h"

namespace tenter::testing {

struct SheetTruth {
  model::Model model;  ///< its values are the truth
  std::vector<std::string> protocols = {"stretch_u", "stretch_v", "shear"};
  int frames = 18;
  double noise = 1.0;      ///< times what the sequence states
  bool two_rates = false;  ///< a clock: the first loop at one frame a second, later ones slower
  unsigned seed = 1;
};

/// cloth_stvk of a compliant fabric with stiffnesses of its own.
model::Model compliant_cloth();

/// A request to diagnose `baseline` on what the truth shows. Fails the test where that has no rest.
diagnosis::SheetRequest sheets_of(const SheetTruth& truth, const model::Model& baseline);

/// Verdicts in lines, for messages.
std::string in_lines(const std::vector<diagnosis::Verdict>& verdicts);

}  // namespace tenter::testing
