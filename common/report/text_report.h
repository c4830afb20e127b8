// SPDX-License-Identifier: Apache-2.0
// A result document as text for a terminal: the headline, the verdicts, the errors, what to look
// at.
#pragma once

#include <string>

#include "common/base/error.h"

namespace tenter::report {

struct TextStyle {
  int width = 90;       ///< columns to wrap at
  bool colour = false;  ///< ANSI colours
};

/// Control characters of the document never reach the terminal.
Expected<std::string> render_text(const std::string& result_json, const TextStyle& style = {});

/// Drops control characters (terminal escapes included) from text of unknown origin; keeps UTF-8.
std::string printable(const std::string& text);

/// Number of columns of UTF-8 text, one per character.
std::size_t columns(const std::string& text);

}  // namespace tenter::report
