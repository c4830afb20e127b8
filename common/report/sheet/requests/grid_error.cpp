// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/document.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

/// "12 mN" and below it "at most 30 mN; 4.0 sigma".
std::string size_cell(const Json& size, const char* unit) {
  if (!size.is_object()) return number_cell(significant({}));
  return number_cell(quantity(number(size, "rms"), unit) + "<div class=\"soft over\">at most " +
                     quantity(number(size, "largest"), unit) + "; " +
                     sigmas(number(size, "sigmas")) + "</div>");
}

}  // namespace

std::string grid_error_section(const Json& result) {
  const Json& grid = member(result, "grid_error");
  if (!grid.is_object()) return "";
  std::string rows;
  for (const Json& capture : list(grid, "captures")) {
    std::string title = escape_html(text(capture, "title"));
    if (const auto without = number(capture, "frames_without"); without && *without > 0.0)
      title += "<div class=\"soft over\">" + significant(without) +
               " frames without an estimate: their forces were not fitted</div>";
    rows += "<tr>" + cell(title) + number_cell(significant(number(capture, "order"))) +
            size_cell(member(capture, "force"), "N") + size_cell(member(capture, "position"), "m") +
            "</tr>\n";
  }
  return panel("grid-error", "The grid's error",
               "What the simulated grid is wrong by, estimated from one of half its spacing, was "
               "taken off and all curves were fitted again: they are the cloth's, and errors "
               "elsewhere on this page are without it. Rounds: " +
                   significant(number(grid, "rounds")) +
                   (flag(grid, "settled") ? "; settled."
                                          : "; the estimate was still changing by " +
                                                sigmas(number(grid, "change_sigmas")) + "."),
               "<th>Capture</th><th class=\"n\">Order</th><th class=\"n\">Force</th><th "
               "class=\"n\">Position</th>",
               rows);
}

}  // namespace tenter::report::sheet
