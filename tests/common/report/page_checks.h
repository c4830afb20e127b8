// SPDX-License-Identifier: Apache-2.0
// What tests of pages ask of them, whatever the page is about.
#pragma once

#include <string>

#include "common/report/html_report.h"
#include "common/report/json_access.h"

namespace tenter::report::fixture {

inline std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

inline std::string page_of(const Json& result) {
  return render_html(result.dump()).value();
}

/// Puts `text` in place of every string of the document except the few that steer the report.
inline void poison(Json& value, const std::string& text) {
  if (value.is_string()) value = text;
  if (value.is_structured())
    for (auto& [key, child] : value.items())
      if (key != "schema" && key != "kind" && key != "role" && key != "verdict" && key != "level")
        poison(child, text);
}

}  // namespace tenter::report::fixture
