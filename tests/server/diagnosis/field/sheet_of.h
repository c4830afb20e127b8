// SPDX-License-Identifier: GPL-3.0-or-later
// Small sheets with a hidden truth, as a diagnosis takes them: the truth walked along a protocol on
// the fit's own grid or a finer one, and the rig's noise.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/diagnosis/field/diagnose_sheet.h"

namespace tenter::testing {

struct SheetTruth {
  model::Model model;  ///< its values are the truth
  std::vector<std::string> protocols = {"stretch_u", "stretch_v", "shear"};
  int frames = 18;
  double noise = 1.0;       ///< times what the sequence states
  double load_cells = 1.0;  ///< noise and sigma of forces, times the rig's
  int cells = 8;            ///< of the protocol's lattice, a side, at whose nodes points are seen
  int fineness = 1;         ///< cells of the truth for one of these, along a side
  int fit_fineness = 1;     ///< and of the fit
  bool has_finer = false;   ///< the request comes with grids of half the spacing
  /// What is otherwise than the capture says while it is measured: masses, say.
  std::function<void(estimation::Sequence&)> otherwise = nullptr;
  bool two_rates = false;  ///< a clock: the first loop at one frame a second, later ones slower
  unsigned seed = 1;
};

/// cloth_stvk of a compliant fabric with stiffnesses of its own.
model::Model compliant_cloth();

/// A request to diagnose `baseline` on what the truth shows. Fails the test where that has no rest.
diagnosis::SheetRequest sheets_of(const SheetTruth& truth, const model::Model& baseline);

/// The request's sequences, a second a frame and no clock.
diagnosis::FieldData data_of(const diagnosis::SheetRequest& request);

/// Fails the test where there is no diagnosis.
diagnosis::SheetDiagnosis diagnosed(const diagnosis::SheetRequest& request, int threads = 2);
const diagnosis::Verdict& first(const diagnosis::SheetDiagnosis& d);

/// Verdicts in lines, for messages; then what was tried, and the checklist.
std::string in_lines(const std::vector<diagnosis::Verdict>& verdicts);
std::string in_lines(const diagnosis::SheetDiagnosis& d);

}  // namespace tenter::testing
