// SPDX-License-Identifier: GPL-3.0-or-later
// Options that are numbers, checked by a table: one clear sentence names the first bad one.
//
//   return check_numbers({{"tolerance_N", options.tolerance_N, OptionRange::not_negative}, ...});
#pragma once

#include <initializer_list>

#include "common/base/error.h"

namespace tenter::mechanics {

enum class OptionRange { not_negative, positive };

struct OptionRow {
  const char* name;
  double value;
  OptionRange range;
};

/// bad_input names the option, its value and what it must be; infinite and NaN are never good.
Expected<void> check_numbers(std::initializer_list<OptionRow> rows);

}  // namespace tenter::mechanics
