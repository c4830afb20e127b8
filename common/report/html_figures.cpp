// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_figures.h"

#include <set>

#include "common/report/html_text.h"
#include "common/report/svg_plot.h"
#include "common/report/words.h"

namespace tenter::report {

namespace {

std::vector<double> numbers(const Json& series, const char* key) {
  std::vector<double> values;
  for (const Json& value : list(series, key))
    values.push_back(number(value).value_or(std::numeric_limits<double>::quiet_NaN()));
  return values;
}

/// Said by the series, or by its name, or by which way x goes.
bool is_unloading(const Json& series, const std::vector<double>& x) {
  const std::string branch = text(series, "branch");
  if (!branch.empty()) return branch == "unload";
  for (const char* key : {"name", "block"})
    if (text(series, key).find("unload") != std::string::npos) return true;
  for (const char* key : {"name", "block"})
    if (text(series, key).find("load") != std::string::npos) return false;
  return x.size() > 1 && x.back() < x.front();
}

std::string axis_label(const Json& axis) {
  const std::string unit = text(axis, "unit");
  std::string label = text(axis, "name");
  if (!unit.empty() && unit != "1") label += " (" + unit + ")";
  return label;
}

struct Key {
  std::string shows;  ///< CSS classes of the groups it stands for
  std::string words;
};

Key key_of(const std::string& role, bool loop, bool residual, bool unloading,
           const ModelWords& models) {
  const std::string left = residual ? "left by the " : "";
  if (role == "baseline" && !models.are_two) return {"baseline", left + "model"};
  if (role == "baseline") return {"baseline", left + models.baseline};
  if (role == "extended") return {"extended", left + models.extended};
  if (role == "outlier") return {"outlier", "outlier, kept out of the fit"};
  if (!loop) return {"measured", "measured"};
  return unloading ? Key{"measured unload", "measured, unloading"}
                   : Key{"measured load", "measured, loading"};
}

PlotSeries::Mark mark_of(const std::string& role, const std::string& said, bool residual,
                         bool unloading) {
  if (said == "line") return PlotSeries::Mark::line;
  if (said == "dots") return PlotSeries::Mark::dots;
  if (role == "outlier") return PlotSeries::Mark::crosses;
  if (role == "baseline" || role == "extended")
    return residual ? PlotSeries::Mark::dots : PlotSeries::Mark::line;
  return unloading ? PlotSeries::Mark::open_dots : PlotSeries::Mark::dots;
}

std::string legend_swatch(const std::string& css_class, PlotSeries::Mark mark) {
  std::string shapes;
  switch (mark) {
    case PlotSeries::Mark::dots:
      shapes = "<path class=\"dot\" d=\"M13 6h0\"/>";
      break;
    case PlotSeries::Mark::open_dots:
      shapes = "<path class=\"dot\" d=\"M13 6h0\"/><path class=\"hole\" d=\"M13 6h0\"/>";
      break;
    case PlotSeries::Mark::line:
      shapes = "<path class=\"line\" d=\"M1 6H25\"/>";
      break;
    case PlotSeries::Mark::crosses:
      shapes = "<path class=\"cross\" d=\"M9 2l8 8M9 10l8 -8\"/>";
      break;
  }
  return "<svg class=\"" + css_class + "\" viewBox=\"0 0 26 12\" aria-hidden=\"true\">" + shapes +
         "</svg>";
}

/// A title that ends with the capture's, which stands above it, without that end.
std::string short_title(std::string title, const std::string& capture_title) {
  const std::string end = ", " + capture_title;
  if (title.size() > end.size() && title.compare(title.size() - end.size(), end.size(), end) == 0)
    title.resize(title.size() - end.size());
  return title;
}

/// `heading` is HTML: the capture that the figure is of.
std::string figure_html(const Json& figure, const std::string& capture_title,
                        const std::string& heading, const ModelWords& models) {
  const std::string kind = text(figure, "kind");
  const bool residual = kind.rfind("residual", 0) == 0;
  Plot plot;
  plot.label = short_title(text(figure, "title"), capture_title);
  plot.x_label = axis_label(member(figure, "x"));
  plot.y_label = axis_label(member(figure, "y"));
  plot.zero_line = residual;
  const Json& band = list(figure, "band");
  if (band.size() == 2 && number(band[0]) && number(band[1]))
    plot.band = {{*number(band[0]), *number(band[1])}};

  std::string keys;
  std::set<std::string> keyed;
  // measured below, models above, outliers on top, whatever the order in the document
  for (const char* role : {"measured", "baseline", "extended", "outlier"}) {
    for (const Json& entry : list(figure, "series")) {
      if (text(entry, "role") != role) continue;
      if (!models.are_two && std::string(role) == "extended") continue;
      PlotSeries series;
      series.x = numbers(entry, "x");
      series.y = numbers(entry, "y");
      const bool unloading = kind == "loop" && is_unloading(entry, series.x);
      const Key key = key_of(role, kind == "loop", residual, unloading, models);
      series.name = text(entry, "name");
      if (series.name.empty()) series.name = key.words;
      const std::string block = text(entry, "block");
      if (!block.empty() && series.name.find(block) == std::string::npos)
        series.name += ", " + block;
      series.css_class = key.shows;
      series.mark = mark_of(role, text(entry, "mark"), residual, unloading);
      if (keyed.insert(key.shows).second)
        keys += "<button type=\"button\" aria-pressed=\"true\" data-shows=\"" + key.shows + "\">" +
                legend_swatch(key.shows, series.mark) + escape_html(key.words) + "</button>";
      plot.series.push_back(std::move(series));
    }
  }
  const std::string svg = render_svg(plot);
  if (svg.empty()) return "";
  return "<figure>\n" + (heading.empty() ? "" : "<div class=\"over\">" + heading + "</div>\n") +
         "<figcaption><span>" + escape_html(plot.label) +
         "</span><span class=\"readout\"></span></figcaption>\n" + svg + "<div class=\"keys\">" +
         keys + "</div>\n</figure>\n";
}

/// The figures of some kinds, capture after capture in the order of the result's list.
std::string section(const Json& result, const std::string& title, const std::string& anchor,
                    const std::string& note, const std::set<std::string>& kinds, bool all_others,
                    const ModelWords& models) {
  static const std::set<std::string> known = {"loop",          "transverse", "residual_strain",
                                              "residual_time", "weights",    "strip_profile",
                                              "curvature",     "unloading",  "residual_torque"};
  const auto wanted = [&](const Json& figure) {
    const std::string kind = text(figure, "kind");
    return all_others ? known.count(kind) == 0 : kinds.count(kind) == 1;
  };
  const Json& captures = list(result, "captures");
  std::set<std::string> listed;
  std::string figures;
  for (const Json& capture : captures) {
    const std::string id = text(capture, "id");
    listed.insert(id);
    std::string heading = escape_html(text(capture, "title"));
    if (flag(capture, "synthetic")) heading += " <span class=\"badge synthetic\">SYNTHETIC</span>";
    for (const Json& figure : list(result, "figures"))
      if (text(figure, "capture") == id && wanted(figure))
        figures += figure_html(figure, text(capture, "title"), heading, models);
  }
  for (const Json& figure : list(result, "figures"))
    if (listed.count(text(figure, "capture")) == 0 && wanted(figure))
      figures += figure_html(figure, "", "", models);
  if (figures.empty()) return "";
  return "<section id=\"" + anchor + "\">\n<h2>" + title + "</h2>\n" +
         (note.empty() ? "" : "<p class=\"soft\">" + note + "</p>\n") +
         "<div class=\"figures\">\n" + figures + "</div>\n</section>\n";
}

}  // namespace

std::string figure_sections(const Json& result, const ModelWords& models) {
  return section(result, "Readings of the test", "test",
                 "What was read, every reading, and the model with the numbers above.",
                 {"weights", "strip_profile", "curvature", "unloading"}, false, models) +
         section(result, "Loops", "loops",
                 "Every reading as it was measured, loading and unloading apart, nothing averaged; "
                 "the models run the same path.",
                 {"loop"}, false, models) +
         section(result, "Transverse stretches", "transverse",
                 "The directions that nothing pulls, where they were measured.", {"transverse"},
                 false, models) +
         section(result, "Residuals", "residuals",
                 "Measured minus model; a shaded band is one standard deviation of the noise.",
                 {"residual_strain", "residual_time", "residual_torque"}, false, models) +
         section(result, "More figures", "figures", "", {}, true, models);
}

}  // namespace tenter::report
