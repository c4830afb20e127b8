// SPDX-License-Identifier: Apache-2.0
// What stands in a table where nothing was measured.
#pragma once

#include <limits>

namespace tenter {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace tenter
