// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/figure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/report/experiment/found.h"
#include "common/report/html_text.h"
#include "common/report/svg_file.h"
#include "common/report/text_report.h"

namespace tenter::report {

namespace {

constexpr double kCell = 280.0, kPictureHeight = 220.0, kLine = 18.0, kEdge = 16.0;
constexpr std::size_t kMostAcross = 4;

std::string style() {
  return "<style>" + plot_style() +
         ".title{font-size:17px;font-weight:600}.run{font-weight:600}.soft{fill:#5d6672}</style>\n";
}

std::string placed(const char* what, double x, double y, const std::string& inside) {
  char begin[96];
  std::snprintf(begin, sizeof begin, "<%s x=\"%.1f\" y=\"%.1f\"", what, x, y);
  return begin + inside;
}

std::string words_at(double x, double y, const std::string& words, const char* css,
                     const char* anchor = "start") {
  return placed("text", x, y,
                std::string(" class=\"") + css + "\" text-anchor=\"" + anchor + "\">" +
                    escape_html(words) + "</text>\n");
}

/// The largest scale at which the pictures of this number fit for every run.
std::optional<double> common_scale(const Found& found, std::size_t picture, const Canvas& canvas) {
  std::optional<double> scale;
  for (const RunFound& run : found.runs) {
    if (picture >= run.pictures.size()) continue;
    const auto extent = seen_extent(run.pictures[picture].points, run.pictures[picture].view);
    const auto fits = extent ? fitting_scale(*extent, canvas) : std::nullopt;
    if (fits) scale = std::min(*fits, scale.value_or(*fits));
  }
  return scale;
}

/// A bar of a round length.
std::string scale_bar(double x, double y, double pixels_per_m) {
  double length = std::pow(10.0, std::floor(std::log10(80.0 / pixels_per_m)));
  for (const double factor : {5.0, 2.0})
    if (factor * length * pixels_per_m <= 80.0) {
      length *= factor;
      break;
    }
  char bar[160];
  std::snprintf(bar, sizeof bar, "<path class=\"axis\" d=\"M%.1f %.1fv4h%.1fv-4\"/>", x, y - 4.0,
                length * pixels_per_m);
  char words[32];
  std::snprintf(words, sizeof words, "%g mm", 1e3 * length);
  return bar + words_at(x + length * pixels_per_m + 6.0, y + 1.0, words, "soft");
}

/// Rows of pictures of one title; moves `y` below them.
std::string pictures(const Found& found, std::size_t picture, double& y) {
  const Canvas canvas{kCell - 10.0, kPictureHeight, 8.0, std::nullopt};
  const auto scale = common_scale(found, picture, canvas);
  if (!scale) return "";
  std::string svg;
  Canvas drawn = canvas;
  drawn.pixels_per_m = scale;
  for (std::size_t r = 0; r < found.runs.size(); ++r) {
    const RunFound& run = found.runs[r];
    const double x = kEdge + kCell * static_cast<double>(r % kMostAcross);
    if (r % kMostAcross == 0 && r > 0) y += kPictureHeight + 2.0 * kLine;
    if (picture >= run.pictures.size()) continue;
    const FoundPicture& shown = run.pictures[picture];
    svg += words_at(x + 4.0, y + 13.0, run.name, "run") +
           words_at(x + 4.0, y + 28.0, shown.title, "soft");
    const std::string paths = painted_mesh(shown.points, run.triangles, shown.view, drawn);
    if (paths.empty())
      svg += words_at(x + 4.0, y + 60.0, "the run ended before", "soft");
    else
      svg += placed("svg", x, y + 2.0 * kLine,
                    " width=\"270\" height=\"220\" overflow=\"hidden\">" + paths + "</svg>\n");
    svg += scale_bar(x + 6.0, y + 2.0 * kLine + kPictureHeight - 4.0, *scale);
  }
  y += kPictureHeight + 3.0 * kLine;
  return svg;
}

/// Words cut into lines of at most `width` letters at blanks.
std::vector<std::string> folded(const std::string& words, std::size_t width) {
  std::vector<std::string> lines(1);
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    const std::string word = words.substr(at, end - at);
    if (!lines.back().empty() && columns(lines.back()) + 1 + columns(word) > width)
      lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    at = end + 1;
  }
  return lines;
}

std::string number_table(const Found& found, double width, double& y) {
  if (found.heads.empty()) return "";
  constexpr double kNames = 210.0;
  const double column =
      std::min(150.0, (width - 2.0 * kEdge - kNames) / static_cast<double>(found.heads.size()));
  const auto right = [column](std::size_t m) {
    return kEdge + kNames + column * static_cast<double>(m + 1) - 6.0;
  };
  std::string svg;
  std::size_t most = 1;
  for (std::size_t m = 0; m < found.heads.size(); ++m) {
    const auto lines = folded(found.heads[m], static_cast<std::size_t>(column / 6.6));
    most = std::max(most, lines.size());
    for (std::size_t l = 0; l < lines.size(); ++l)
      svg += words_at(right(m), y + 13.0 + 15.0 * static_cast<double>(l), lines[l], "soft", "end");
  }
  y += 15.0 * static_cast<double>(most) + 4.0;
  for (const RunFound& run : found.runs) {
    char rule[80];
    std::snprintf(rule, sizeof rule, "<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", kEdge, y,
                  right(found.heads.size() - 1) + 6.0);
    svg += rule + words_at(kEdge + 4.0, y + 14.0, run.name, "run");
    for (std::size_t m = 0; m < run.numbers.size(); ++m)
      svg += words_at(right(m), y + 14.0, run.numbers[m], "number", "end");
    y += kLine + 2.0;
    if (run.reason.empty()) continue;
    svg += words_at(kEdge + 4.0, y + 12.0, "ended early: " + run.reason, "soft");
    y += kLine;
  }
  y += kLine;
  return svg;
}

std::string plots(const Found& found, double& width, double& y) {
  std::string svg;
  if (found.runs.empty()) return svg;
  for (std::size_t c = 0; c < found.runs.front().lines.size(); ++c) {
    const FoundLine& first = found.runs.front().lines[c];
    Plot plot;
    plot.label = first.words;
    plot.x_label = first.x_label;
    plot.y_label = first.y_label;
    plot.width = 560;
    plot.height = 340;
    std::string keys;
    double key_y = y + kLine + 24.0;
    for (std::size_t r = 0; r < found.runs.size(); ++r) {
      if (c >= found.runs[r].lines.size()) continue;
      const FoundLine& line = found.runs[r].lines[c];
      const std::string css = line_class(r);
      plot.series.push_back({found.runs[r].name, css, PlotSeries::Mark::line, line.x, line.y});
      char stroke[120];
      std::snprintf(stroke, sizeof stroke,
                    "<g class=\"%s\"><path class=\"line\" d=\"M%.1f %.1fh22\"/></g>", css.c_str(),
                    kEdge + 574.0, key_y - 4.0);
      keys += stroke + words_at(kEdge + 602.0, key_y, found.runs[r].name, "key");
      key_y += kLine;
    }
    const std::string drawn = placed_plot(plot, kEdge, y + kLine);
    if (drawn.empty()) continue;
    svg += words_at(kEdge + 4.0, y + 13.0, first.words, "run") + keys + drawn;
    y = std::max(y + kLine + 350.0, key_y);
    width = std::max(width, 2.0 * kEdge + 780.0);
  }
  return svg;
}

}  // namespace

std::string drawn(const Found& found) {
  const auto across = static_cast<double>(std::min(kMostAcross, found.runs.size()));
  double width = std::max(2.0 * kEdge + kCell * across, 640.0);
  double y = 14.0;
  std::string body = words_at(kEdge + 4.0, y + 16.0, found.scene + " with " + found.model, "title");
  y += 34.0;
  std::size_t most = 0;
  for (const RunFound& run : found.runs) most = std::max(most, run.pictures.size());
  for (std::size_t p = 0; p < most; ++p) body += pictures(found, p, y);
  width = std::max(width, 2.0 * kEdge + 210.0 + 110.0 * static_cast<double>(found.heads.size()));
  body += number_table(found, width, y);
  body += plots(found, width, y);
  char head[240];
  std::snprintf(head, sizeof head,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
                "width=\"%.0f\" height=\"%.0f\">\n<rect width=\"100%%\" height=\"100%%\" "
                "fill=\"#ffffff\"/>\n",
                width, y, width, y);
  return head + style() + body + "</svg>\n";
}

Expected<std::string> experiment_svg(const std::string& result_json) {
  const auto found = found_of(result_json);
  if (!found) return tl::unexpected(found.error());
  return drawn(*found);
}

Expected<std::string> experiment_text(const std::string& result_json) {
  const auto found = found_of(result_json);
  if (!found) return tl::unexpected(found.error());
  std::string all;
  for (const RunFound& run : found->runs) {
    all += printable(run.name) + "\n";
    for (std::size_t m = 0; m < run.numbers.size(); ++m)
      all += "  " + printable(found->heads[m]) + ": " + run.numbers[m] + "\n";
    if (!run.reason.empty()) all += "  ended early: " + printable(run.reason) + "\n";
  }
  return all;
}

}  // namespace tenter::report
