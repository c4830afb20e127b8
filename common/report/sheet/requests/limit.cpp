// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

std::string limit_section(const Json& result) {
  const Json& limit = member(result, "limit");
  if (!limit.is_object()) return "";
  const bool reached = flag(limit, "is_reached");
  std::string value = significant(number(limit, "energy_max"));
  if (number(limit, "std_error")) value += " \u00b1 " + significant(number(limit, "std_error"));
  if (!reached)
    value = number(limit, "at_least") ? "at least " + significant(number(limit, "at_least"))
                                      : significant({});
  const std::string rows =
      "<tr>" +
      cell("<code>" + escape_html(text(limit, "id")) + "</code><div class=\"soft over\">" +
           escape_html(text(limit, "message")) + "</div>") +
      cell(badge(reached ? "good" : "warn", reached ? "reached" : "not reached")) +
      number_cell(significant(number(limit, "given"))) + number_cell(value) +
      number_cell(significant(number(limit, "active_frames"))) +
      number_cell(significant(number(limit, "cost_without")) + kArrow +
                  significant(number(limit, "cost"))) +
      "</tr>\n";
  return panel("limit", "Energy limit",
               "The largest energy density that the material allows, fitted in turns with the "
               "curves; " +
                   escape_html(text(limit, "unit")) + ".",
               "<th>Limit</th><th></th><th class=\"n\">Given</th><th class=\"n\">Fitted</th><th "
               "class=\"n\">Frames at it</th><th class=\"n\">Cost without, with</th>",
               rows);
}

}  // namespace tenter::report::sheet
