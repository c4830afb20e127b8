// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/curves.h"

#include <algorithm>
#include <limits>

#include "common/report/html_text.h"
#include "common/report/svg_plot.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

std::vector<double> numbers(const Json& object, const char* key) {
  std::vector<double> values;
  for (const Json& value : list(object, key))
    values.push_back(number(value).value_or(std::numeric_limits<double>::quiet_NaN()));
  return values;
}

std::string axis_label(const Json& axis) {
  const std::string unit = text(axis, "unit");
  std::string label = text(axis, "name");
  if (!unit.empty() && unit != "1") label += " (" + unit + ")";
  return label;
}

std::string key(const char* css, const char* shape, const char* words) {
  return "<button type=\"button\" aria-pressed=\"true\" data-shows=\"" + std::string(css) +
         "\"><svg class=\"" + css + "\" viewBox=\"0 0 26 12\" aria-hidden=\"true\">" + shape +
         "</svg>" + words + "</button>";
}

std::string curve_html(const Json& curve) {
  Plot plot;
  plot.label = effect_words(text(curve, "term"));
  plot.x_label = axis_label(member(curve, "x"));
  plot.y_label = axis_label(member(curve, "y"));
  const std::vector<double> strain = numbers(curve, "strain");
  const std::vector<double> start = numbers(curve, "start");
  PlotRibbon band{"95 % interval", strain, numbers(curve, "lo"), numbers(curve, "hi")};
  std::string keys;
  if (!start.empty()) {
    plot.series.push_back({"starting model", "baseline", PlotSeries::Mark::line, strain, start});
    keys += key("baseline", "<path class=\"line\" d=\"M1 6H25\"/>", "starting model");
  }
  plot.series.push_back(
      {"fitted model", "extended", PlotSeries::Mark::line, strain, numbers(curve, "stress")});
  keys += key("extended", "<path class=\"line\" d=\"M1 6H25\"/>", "fitted model");
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (std::any_of(band.lo.begin(), band.lo.end(), is_finite)) {
    plot.ribbons.push_back(std::move(band));
    keys += key("ribbon", "<path d=\"M1 1h24v10h-24z\"/>", "95 % interval");
  }
  std::string note;
  const Json& reached = list(curve, "reached");
  if (reached.size() == 2 && number(reached[0]) && number(reached[1])) {
    const double lo = *number(reached[0]), hi = *number(reached[1]);
    const auto rounded = [&](double end) {  // zero but for the last digits is zero
      return significant(std::abs(end) < 1e-9 * (hi - lo) ? 0.0 : end);
    };
    plot.seen = {{lo, hi}};
    note = "Reached by the data: " + rounded(lo) + " to " + rounded(hi) + "; shaded: never seen.";
  }
  if (const std::optional<double> count = number(curve, "control_points"))
    note += std::string(note.empty() ? "" : " ") + significant(count) +
            (*count == 1.0 ? " control point." : " control points.");
  const std::string svg = render_svg(plot);
  if (svg.empty()) return "";
  return "<figure>\n<figcaption><span>" + escape_html(plot.label) + " <code>" +
         escape_html(text(curve, "law")) + "</code></span><span class=\"readout\"></span>" +
         "</figcaption>\n" + svg + "<div class=\"keys\">" + keys + "</div>\n" +
         (note.empty() ? "" : "<p class=\"over\">" + note + "</p>\n") + "</figure>\n";
}

}  // namespace

std::string curve_section(const Json& result) {
  std::string figures;
  for (const Json& curve : list(result, "curves")) figures += curve_html(curve);
  if (figures.empty()) return "";
  return "<section id=\"curves\">\n<h2>Curves</h2>\n<p class=\"soft\">What each term of the model "
         "answers to strain.</p>\n<div class=\"figures\">\n" +
         figures + "</div>\n</section>\n";
}

}  // namespace tenter::report::sheet
