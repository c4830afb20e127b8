// SPDX-License-Identifier: Apache-2.0
// How ids and numbers of a result read to a person: the same words in the page and on the terminal.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tenter::report {

/// "internal_friction" -> "internal friction", "load_cell_offset" -> "load cell offset"; unknown
/// ids lose their '_'.
std::string effect_words(std::string_view id);

/// "NOT_EXCITED" -> "not excited".
std::string verdict_words(std::string_view verdict);

/// Share 0..1 as "62 %", "4.1 %", "0.08 %"; none: an en dash.
std::string percent(std::optional<double> share);

/// "55 to 68 %"; "" where there is none, or its ends read the same.
std::string percent_interval(std::optional<double> lo, std::optional<double> hi);

/// "p < 0.001", "p = 0.013"; "" where there is none.
std::string p_value(std::optional<double> p);

/// Four significant digits without needless zeros: "0.01234", "1.2e-07".
std::string significant(std::optional<double> value);

/// "a, b and c".
std::string joined(const std::vector<std::string>& items, std::string_view last = "and");

}  // namespace tenter::report
