// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

std::string convexity_section(const Json& result) {
  const Json& convex = member(result, "convexity");
  if (!convex.is_object()) return "";
  const auto verdict = [](bool is_convex) {
    return badge(is_convex ? "good" : "warn", is_convex ? "convex" : "not convex");
  };
  const Json& least = member(convex, "least");
  std::string where;
  if (least.is_object() && !flag(convex, "was_convex"))
    where = "<div class=\"soft over\">least so: <code>" + escape_html(text(least, "term")) +
            "</code>, eigenvalue " + significant(number(least, "eigenvalue")) + "</div>";
  const std::string rows =
      "<tr>" +
      cell("<span class=\"cause\">" + escape_html(effect_words(text(convex, "way"))) +
           "</span><div class=\"soft over\">" + escape_html(text(convex, "message")) + "</div>") +
      cell(verdict(flag(convex, "was_convex")) + where) + cell(verdict(flag(convex, "is_convex"))) +
      number_cell(significant(number(convex, "cost_before")) + kArrow +
                  significant(number(convex, "cost_after"))) +
      number_cell(significant(number(convex, "projections"))) +
      number_cell(significant(number(convex, "iterations"))) + "</tr>\n";
  return panel("convexity", "Convexity",
               "A convex energy has one rest for each load; what it costs is how much worse the "
               "fitted captures are met.",
               "<th>Way</th><th>Before</th><th>After</th><th class=\"n\">Cost</th><th class=\"n\">"
               "Projections</th><th class=\"n\">Iterations</th>",
               rows);
}

}  // namespace tenter::report::sheet
