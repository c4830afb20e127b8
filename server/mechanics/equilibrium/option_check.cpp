// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/option_check.h"

#include <cmath>
#include <string>

namespace tenter::mechanics {

Expected<void> check_numbers(std::initializer_list<OptionRow> rows) {
  for (const OptionRow& row : rows) {
    const bool may_be_zero = row.range == OptionRange::not_negative;
    const bool is_good = may_be_zero ? row.value >= 0.0 : row.value > 0.0;
    if (!is_good || !std::isfinite(row.value))
      return bad_input(std::string("option ") + row.name + " is " + std::to_string(row.value) +
                       " and must be " + (may_be_zero ? "not negative" : "positive") +
                       " and finite");
  }
  return {};
}

}  // namespace tenter::mechanics
