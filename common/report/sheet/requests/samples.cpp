// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/document.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

/// "25 mm, 75 mm": of the sample's number, from 1.
std::string place_of(const Json& samples, std::optional<double> sample) {
  const Json& places = list(samples, "positions_m");
  if (!sample || !(*sample >= 1.0) || *sample > static_cast<double>(places.size())) return "";
  const Json& place = places[static_cast<std::size_t>(*sample) - 1];
  if (!place.is_array() || place.size() != 2) return "";
  return quantity(number(place[0]), "m") + ", " + quantity(number(place[1]), "m");
}

}  // namespace

std::string sample_section(const Json& result) {
  const Json& samples = member(result, "samples");
  if (!samples.is_object()) return "";
  std::string rows;
  for (const Json& step : list(samples, "steps")) {
    const std::optional<double> sample = number(step, "sample");
    const bool kept = flag(step, "kept");
    const std::optional<double> left_out = number(step, "rows_left_out");
    std::string note;
    if (left_out && *left_out > 0.0)
      note = "<div class=\"soft over\">without " + significant(left_out) +
             " rows of frames that are folded otherwise</div>";
    rows += "<tr>" + number_cell(significant(sample)) + cell(place_of(samples, sample)) +
            cell(badge(kept ? "good" : "plain", kept ? "kept" : "put back")) +
            number_cell(significant(number(step, "training"))) +
            number_cell(significant(number(step, "held_out_before")) + kArrow +
                        significant(number(step, "held_out")) + note) +
            number_cell(significant(number(step, "sigmas"))) + "</tr>\n";
  }
  std::string note =
      "Stiffness at samples of the material, added where the residual asks for it and kept where "
      "the captures that were held out gain by it. Terms of sample 5 are called weft_5 and so on.";
  if (!text(samples, "message").empty()) note = escape_html(text(samples, "message"));
  if (rows.empty()) rows = "<tr><td colspan=\"6\">none was tried</td></tr>\n";
  return panel("samples", "Material samples", note,
               "<th class=\"n\">Sample</th><th>At u, v</th><th></th><th class=\"n\">Cost, "
               "fitted</th><th class=\"n\">Cost, held out</th><th class=\"n\">Fall over its "
               "scatter</th>",
               rows);
}

}  // namespace tenter::report::sheet
