// SPDX-License-Identifier: Apache-2.0
// From the unit that a laboratory wrote down to SI: value_SI = factor * value + offset. Names are
// those of UDUNITS-2 ("mm", "kPa", "N/mm", "lbf", "percent", "min", "degree", ...).
//
//   Expected<UnitConversion> to_si = conversion("kPa", "Pa");
//   double pascal = to_si->apply(4.2);
//
// Safe to call from any thread.
#pragma once

#include <string>

#include "common/base/error.h"

namespace tenter::capture {

struct UnitConversion {
  double factor = 1.0;
  double offset = 0.0;
  bool identity = true;  ///< values pass untouched, bit for bit
  double apply(double value) const { return identity ? value : factor * value + offset; }
  double apply_to_difference(double value) const { return identity ? value : factor * value; }
};

/// Fails with a sentence that names both units where `from` is unknown or measures something else.
Expected<UnitConversion> conversion(const std::string& from, const std::string& to);

}  // namespace tenter::capture
