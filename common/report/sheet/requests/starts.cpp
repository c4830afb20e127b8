// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "common/report/html_text.h"
#include "common/report/sheet/requests/requests.h"
#include "common/report/svg_plot.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

std::string series_key(const char* css, const char* shape, const char* words) {
  return "<button type=\"button\" aria-pressed=\"true\" data-shows=\"" + std::string(css) +
         "\"><svg class=\"" + css + "\" viewBox=\"0 0 26 12\" aria-hidden=\"true\">" + shape +
         "</svg>" + words + "</button>";
}

constexpr const char* kDot = "<path class=\"dot\" d=\"M13 6h0\"/>";

}  // namespace

std::string start_section(const Json& result) {
  const Json& starts = member(result, "starts");
  const Json& outcomes = list(starts, "outcomes");
  const std::optional<double> lowest =
      outcomes.empty() ? std::nullopt : number(outcomes[0], "cost");
  if (!lowest || !(*lowest > 0.0)) return "";
  const double share = number(starts, "share").value_or(0.0);
  PlotSeries best{"in the best basin", "extended", PlotSeries::Mark::dots, {}, {}};
  PlotSeries others{"above it", "measured", PlotSeries::Mark::dots, {}, {}};
  PlotSeries own{"from the fit's own values", "outlier", PlotSeries::Mark::crosses, {}, {}};
  int without = 0;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const std::optional<double> cost = number(outcomes[k], "cost");
    if (!cost || !(*cost > 0.0)) {
      ++without;
      continue;
    }
    const double height = std::log10(*cost / *lowest);
    const auto place = static_cast<double>(k + 1);
    PlotSeries& into = *cost <= (1.0 + share) * *lowest ? best : others;
    into.x.push_back(place);
    into.y.push_back(height);
    if (number(outcomes[k], "start") == 0.0) {
      own.x.push_back(place);
      own.y.push_back(height);
    }
  }
  Plot plot;
  plot.label = "Costs of all starts in their order";
  plot.x_label = "place";
  plot.y_label = "log10 of the cost over the lowest";
  plot.zero_line = true;
  std::string keys = series_key("extended", kDot, "in the best basin");
  if (!others.x.empty()) keys += series_key("measured", kDot, "above it");
  keys += series_key("outlier", "<path class=\"cross\" d=\"M9 2l8 8M9 10l8 -8\"/>",
                     "from the fit's own values");
  plot.series = {std::move(best), std::move(others), std::move(own)};
  const std::string svg = render_svg(plot);
  if (svg.empty()) return "";
  std::string note = significant(number(starts, "in_best_basin")) + " of " +
                     std::to_string(outcomes.size()) + " starts ended within " + percent(share) +
                     " of the lowest cost, " + significant(lowest) + ".";
  if (without > 0)
    note += " " + std::to_string(without) + (without == 1 ? " start" : " starts") +
            " ended without an equilibrium and " + (without == 1 ? "is" : "are") + " not drawn.";
  if (flag(starts, "is_better"))
    note += " The fit was taken from the lowest, as its own values ended at " +
            significant(number(starts, "cost_of_fit")) + ".";
  return "<section id=\"starts\">\n<h2>Random starts</h2>\n<p class=\"soft\">The same fit from the "
         "fitted values times random factors up to " +
         significant(number(starts, "widest")) + " either way, at no more than " +
         significant(number(starts, "frames")) + " frames of a capture; seed " +
         significant(number(starts, "seed")) +
         ".</p>\n<div class=\"figures\">\n<figure>\n<figcaption><span>" + escape_html(plot.label) +
         "</span><span class=\"readout\"></span></figcaption>\n" + svg + "<div class=\"keys\">" +
         keys + "</div>\n<p class=\"over\">" + note + "</p>\n</figure>\n</div>\n</section>\n";
}

}  // namespace tenter::report::sheet
