// SPDX-License-Identifier: Apache-2.0
// The small parts that the tables of a page are made of. What is called `html` or `words` here is
// HTML already; only a badge escapes its words.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/report/json_access.h"

namespace tenter::report {

inline constexpr const char* kArrow = " \u2192 ";

/// `css` one of good, warn, bad, sensor, named, synthetic, plain.
std::string badge(const std::string& css, const std::string& words);

/// A bar from 0 to `value` of `full`, with a whisker for an interval and a dashed line at `limit`.
std::string meter(std::optional<double> value, double full, const char* css,
                  std::optional<double> lo = {}, std::optional<double> hi = {},
                  std::optional<double> limit = {});

std::string cell(const std::string& html);
std::string number_cell(const std::string& html);

/// A section with a table; "" without rows.
std::string panel(const std::string& anchor, const std::string& title, const std::string& note,
                  const std::string& head, const std::string& rows);

struct PageSection {
  const char* anchor;
  const char* words;
};

/// Subject, headline, a note on synthetic captures, and links to those of `sections` that
/// `details` (HTML) has. `over` and `title` are plain text.
std::string page_header(const Json& result, const std::string& over, const std::string& title,
                        std::span<const PageSection> sections, const std::string& details);

/// How the last fit ended, in one line; "" where the result does not say.
std::string fit_note(const Json& result);

std::string card(const std::string& name, const std::string& value, const std::string& note);

}  // namespace tenter::report
