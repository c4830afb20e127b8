// SPDX-License-Identifier: Apache-2.0
#include "common/report/svg_file.h"

#include <algorithm>
#include <cstdio>

#include "common/report/html_text.h"

namespace tenter::report {

namespace {

constexpr const char* kLines[kLineColours] = {"#1f66ad", "#c07a2b", "#2b7a4b", "#b3261e",
                                              "#7a4fa3", "#4a5562", "#0d8a8a", "#a0458a"};
constexpr double kTitle = 24.0, kKeyLine = 17.0;

std::string labelled(double x, double y, const std::string& css, const std::string& words) {
  char place[96];
  std::snprintf(place, sizeof place, "<text x=\"%.1f\" y=\"%.1f\" class=\"%s\">", x, y,
                css.c_str());
  return place + escape_html(words) + "</text>\n";
}

/// Series with a name, below their chart.
std::string line_keys(const Plot& plot, double x, double y) {
  std::string svg;
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) continue;
    char stroke[160];
    std::snprintf(stroke, sizeof stroke,
                  "<g class=\"%s\"><path class=\"line\" d=\"M%.1f %.1fh22\"/></g>",
                  series.css_class.c_str(), x + 62.0, y - 4.0);
    svg += stroke + labelled(x + 90.0, y, "key", series.name);
    y += kKeyLine;
  }
  return svg;
}

}  // namespace

std::string plot_style() {
  std::string css =
      "text{font:12px system-ui,\"DejaVu Sans\",sans-serif;fill:#1c2127}"
      ".tick{fill:#5d6672;font-size:11px}.grid{stroke:#e2e3e0;fill:none}"
      ".axis{stroke:#5d6672;fill:none}.line{fill:none;stroke-width:1.6;stroke-linejoin:round}"
      ".dot{fill:none;stroke-width:3.6;stroke-linecap:round}.cross{fill:none;stroke-width:1.5}"
      ".hole{fill:none;stroke:#fff;stroke-width:2.2;stroke-linecap:round}.cursor{fill:none}"
      ".band,.ribbon path{fill:#1f66ad;fill-opacity:.12}.unseen{fill:#5d6672;fill-opacity:.09}"
      ".measured path{stroke:#4a5562}.baseline path{stroke:#c07a2b}.extended path{stroke:#1f66ad}"
      ".outlier path{stroke:#b3261e}";
  for (std::size_t i = 0; i < kLineColours; ++i)
    css += "." + line_class(i) + " path{stroke:" + kLines[i] + "}";
  return css;
}

std::string line_class(std::size_t index) {
  return "r" + std::to_string(index % kLineColours);
}

std::string placed_plot(const Plot& plot, double x, double y) {
  const std::string drawn = render_svg(plot);
  if (drawn.empty()) return "";
  char place[64];
  std::snprintf(place, sizeof place, "<svg x=\"%.1f\" y=\"%.1f\"", x, y);
  return place + drawn.substr(4);  // behind its own "<svg"
}

std::string svg_file(const std::vector<Plot>& plots, std::size_t across) {
  std::string body;
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;
  std::size_t column = 0;
  for (const Plot& plot : plots) {
    const std::string drawn = placed_plot(plot, x, y + kTitle);
    if (drawn.empty()) continue;
    const double key_y = y + kTitle + plot.height + kKeyLine;
    body += labelled(x + 62.0, y + 17.0, "title", plot.label) + drawn + line_keys(plot, x, key_y);
    x += plot.width;
    width = std::max(width, x);
    height = std::max(height, key_y + kKeyLine * static_cast<double>(plot.series.size()));
    if (++column % std::max<std::size_t>(across, 1) == 0) {
      x = 0.0;
      y = height;
    }
  }
  if (body.empty()) return "";
  char head[240];
  std::snprintf(head, sizeof head,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
                "width=\"%.0f\" height=\"%.0f\">\n<rect width=\"100%%\" height=\"100%%\" "
                "fill=\"#ffffff\"/>\n",
                width, height, width, height);
  return head + ("<style>" + plot_style() + ".title{font-weight:600}</style>\n") + body +
         "</svg>\n";
}

}  // namespace tenter::report
