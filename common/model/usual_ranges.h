// SPDX-License-Identifier: Apache-2.0
// Which stiffness does cloth usually have? A fit that ends elsewhere may be right, but deserves a
// second look at units, thickness and scale.
//
// The ranges are those of ten garment fabrics (H. Wang, J. F. O'Brien, R. Ramamoorthi, "Data-driven
// elastic models for cloth", ACM Transactions on Graphics 30(4), 71, 2011), over all strains and
// curvatures measured there, rounded outwards; `tenter-bench-fabric-ranges` prints them from the
// published parameters.
//
//   if (const auto usual = usual_range(term)) ...  // of every control point of the term's law
//
// Pure; any thread.
#pragma once

#include <optional>

#include "common/model/model.h"

namespace tenter::model {

struct UsualRange {
  double lo = 0.0;  ///< in the unit of the term's parameters
  double hi = 0.0;
};

/// Nothing where cloth's stiffness is not what the parameters say: other laws than constant
/// stiffness and stiffness splines, other strains than those along weft, warp, shear and bending.
std::optional<UsualRange> usual_range(const Term& term);

}  // namespace tenter::model
