// SPDX-License-Identifier: Apache-2.0
#include "common/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "common/report/html_text.h"

namespace tenter::report {

namespace {

constexpr double kLeft = 62.0;
constexpr double kRight = 14.0;
constexpr double kTop = 12.0;
constexpr double kBottom = 46.0;

struct Range {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();

  void include(double value) {
    lo = std::min(lo, value);
    hi = std::max(hi, value);
  }
  bool empty() const { return !(lo <= hi); }
  /// A little air around the data; a single value gets an axis too.
  void pad() {
    double margin = 0.04 * (hi - lo);
    if (!(margin > 0.0)) margin = lo == 0.0 ? 1.0 : 0.1 * std::abs(lo);
    lo -= margin;
    hi += margin;
  }
};

/// Data to picture.
struct Frame {
  Range x;
  Range y;
  double width = 0.0;
  double height = 0.0;

  double px(double value) const {
    return kLeft + (value - x.lo) / (x.hi - x.lo) * (width - kLeft - kRight);
  }
  double py(double value) const {
    return height - kBottom - (value - y.lo) / (y.hi - y.lo) * (height - kTop - kBottom);
  }
};

std::string coordinate(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  std::string out = text;
  if (out.size() > 2 && out.compare(out.size() - 2, 2, ".0") == 0) out.resize(out.size() - 2);
  return out == "-0" ? "0" : out;
}

std::string tick_label(double value, double step) {
  if (std::abs(value) < 1e-9 * step) value = 0.0;
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

bool finite(const PlotSeries& s, std::size_t i) {
  return i < s.y.size() && std::isfinite(s.x[i]) && std::isfinite(s.y[i]);
}

/// One dot per half pixel: zero-length strokes with round ends.
std::string dots_path(const PlotSeries& s, const Frame& frame) {
  std::string d;
  std::set<std::pair<int, int>> drawn;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!finite(s, i)) continue;
    const double px = frame.px(s.x[i]);
    const double py = frame.py(s.y[i]);
    if (!drawn
             .insert(
                 {static_cast<int>(std::lround(2.0 * px)), static_cast<int>(std::lround(2.0 * py))})
             .second)
      continue;
    d += "M" + coordinate(px) + " " + coordinate(py) + "h0";
  }
  return d;
}

std::string crosses_path(const PlotSeries& s, const Frame& frame) {
  std::string d;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!finite(s, i)) continue;
    const double px = frame.px(s.x[i]);
    const double py = frame.py(s.y[i]);
    d += "M" + coordinate(px - 3) + " " + coordinate(py - 3) + "l6 6M" + coordinate(px - 3) + " " +
         coordinate(py + 3) + "l6 -6";
  }
  return d;
}

/// A vertex is left out only if it lies within a third of a pixel of the last one drawn; ends are
/// kept.
std::string line_path(const PlotSeries& s, const Frame& frame) {
  std::string d;
  bool pen_down = false;
  double last_x = 0.0;
  double last_y = 0.0;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!finite(s, i)) {
      pen_down = false;
      continue;
    }
    const double px = frame.px(s.x[i]);
    const double py = frame.py(s.y[i]);
    const bool ends = !finite(s, i + 1) || i + 1 >= s.x.size();
    if (pen_down && !ends && std::hypot(px - last_x, py - last_y) < 0.34) continue;
    d += (pen_down ? "L" : "M") + coordinate(px) + " " + coordinate(py);
    pen_down = true;
    last_x = px;
    last_y = py;
  }
  return d;
}

std::string series_group(const PlotSeries& s, const Frame& frame) {
  std::string shapes;
  const auto path = [&shapes](const std::string& css, const std::string& d) {
    if (!d.empty()) shapes += "<path class=\"" + css + "\" d=\"" + d + "\"/>";
  };
  switch (s.mark) {
    case PlotSeries::Mark::dots:
      path("dot", dots_path(s, frame));
      break;
    case PlotSeries::Mark::open_dots: {
      const std::string d = dots_path(s, frame);
      path("dot", d);
      path("hole", d);
      break;
    }
    case PlotSeries::Mark::line:
      path("line", line_path(s, frame));
      break;
    case PlotSeries::Mark::crosses:
      path("cross", crosses_path(s, frame));
      break;
  }
  if (shapes.empty()) return "";
  return "<g class=\"series " + escape_html(s.css_class) + "\"><title>" + escape_html(s.name) +
         "</title>" + shapes + "</g>\n";
}

std::string ribbon_group(const PlotRibbon& ribbon, const Frame& frame) {
  const std::size_t count = std::min({ribbon.x.size(), ribbon.lo.size(), ribbon.hi.size()});
  std::string there;
  std::string back;
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(ribbon.x[i]) || !std::isfinite(ribbon.lo[i]) || !std::isfinite(ribbon.hi[i]))
      continue;
    const std::string px = coordinate(frame.px(ribbon.x[i])) + " ";
    there += (there.empty() ? "M" : "L") + px + coordinate(frame.py(ribbon.hi[i]));
    back = "L" + px + coordinate(frame.py(ribbon.lo[i])) + back;
  }
  if (there.empty()) return "";
  return "<g class=\"series ribbon\"><title>" + escape_html(ribbon.name) + "</title><path d=\"" +
         there + back + "Z\"/></g>\n";
}

/// What lies outside of the range of x that has data.
std::string unseen_parts(const Plot& plot, const Frame& frame) {
  if (!plot.seen) return "";
  const double left = kLeft;
  const double right = frame.width - kRight;
  const double from = std::clamp(frame.px(plot.seen->first), left, right);
  const double to = std::clamp(frame.px(plot.seen->second), left, right);
  std::string svg;
  for (const auto& [a, b] : {std::pair{left, from}, std::pair{to, right}})
    if (b - a > 0.5)
      svg += "<rect class=\"unseen\" x=\"" + coordinate(a) + "\" y=\"" + coordinate(kTop) +
             "\" width=\"" + coordinate(b - a) + "\" height=\"" +
             coordinate(frame.height - kBottom - kTop) + "\"/>";
  return svg;
}

std::string axes(const Plot& plot, const Frame& frame) {
  std::string svg;
  const double bottom = frame.height - kBottom;
  const double right = frame.width - kRight;
  const std::vector<double> xs = axis_ticks(frame.x.lo, frame.x.hi, 6);
  const std::vector<double> ys = axis_ticks(frame.y.lo, frame.y.hi, 5);
  const double x_step = xs.size() > 1 ? xs[1] - xs[0] : 1.0;
  const double y_step = ys.size() > 1 ? ys[1] - ys[0] : 1.0;
  for (const double y : ys) {
    const std::string py = coordinate(frame.py(y));
    svg += "<path class=\"grid\" d=\"M" + coordinate(kLeft) + " " + py + "H" + coordinate(right) +
           "\"/><text class=\"tick\" text-anchor=\"end\" x=\"" + coordinate(kLeft - 7) + "\" y=\"" +
           coordinate(frame.py(y) + 4) + "\">" + tick_label(y, y_step) + "</text>";
  }
  for (const double x : xs) {
    const std::string px = coordinate(frame.px(x));
    svg += "<path class=\"grid\" d=\"M" + px + " " + coordinate(kTop) + "V" + coordinate(bottom) +
           "\"/><text class=\"tick\" text-anchor=\"middle\" x=\"" + px + "\" y=\"" +
           coordinate(bottom + 17) + "\">" + tick_label(x, x_step) + "</text>";
  }
  svg += "<path class=\"axis\" d=\"M" + coordinate(kLeft) + " " + coordinate(kTop) + "V" +
         coordinate(bottom) + "H" + coordinate(right) + "\"/>";
  if (frame.y.lo < 0.0 && frame.y.hi > 0.0)
    svg += "<path class=\"axis\" d=\"M" + coordinate(kLeft) + " " + coordinate(frame.py(0.0)) +
           "H" + coordinate(right) + "\"/>";
  svg += "<text class=\"axis-label\" text-anchor=\"middle\" x=\"" +
         coordinate((kLeft + right) / 2) + "\" y=\"" + coordinate(frame.height - 9) + "\">" +
         escape_html(plot.x_label) + "</text>";
  const std::string middle = coordinate((kTop + bottom) / 2);
  svg += "<text class=\"axis-label\" text-anchor=\"middle\" transform=\"translate(14 " + middle +
         ") rotate(-90)\">" + escape_html(plot.y_label) + "</text>\n";
  return svg;
}

}  // namespace

std::vector<double> axis_ticks(double lo, double hi, int count) {
  std::vector<double> ticks;
  if (!(hi > lo) || !std::isfinite(hi - lo) || count < 1) return ticks;
  const double raw = (hi - lo) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= raw) {
      step = factor * power;
      break;
    }
  for (double n = std::ceil(lo / step); n * step <= hi; n += 1.0) {
    ticks.push_back(n * step);
    if (ticks.size() > 50) break;
  }
  return ticks;
}

std::string render_svg(const Plot& plot) {
  Frame frame;
  frame.width = plot.width;
  frame.height = plot.height;
  for (const PlotSeries& s : plot.series)
    for (std::size_t i = 0; i < s.x.size(); ++i)
      if (finite(s, i)) {
        frame.x.include(s.x[i]);
        frame.y.include(s.y[i]);
      }
  if (frame.x.empty()) return "";
  for (const PlotRibbon& ribbon : plot.ribbons)
    for (const std::vector<double>* side : {&ribbon.lo, &ribbon.hi})
      for (const double y : *side)
        if (std::isfinite(y)) frame.y.include(y);
  if (plot.zero_line) frame.y.include(0.0);
  if (plot.band) {
    frame.y.include(plot.band->first);
    frame.y.include(plot.band->second);
  }
  frame.x.pad();
  frame.y.pad();
  if (!std::isfinite(frame.x.hi - frame.x.lo) || !std::isfinite(frame.y.hi - frame.y.lo)) return "";

  // the script reads the axes from these attributes to show the values under the pointer
  char scale[200];
  std::snprintf(scale, sizeof scale,
                "data-x0=\"%.9g\" data-x1=\"%.9g\" data-y0=\"%.9g\" data-y1=\"%.9g\" "
                "data-box=\"%g %g %g %g\"",
                frame.x.lo, frame.x.hi, frame.y.lo, frame.y.hi, kLeft, kTop, frame.width - kRight,
                frame.height - kBottom);
  const std::string w = std::to_string(plot.width);
  const std::string h = std::to_string(plot.height);
  std::string svg = "<svg class=\"plot\" role=\"img\" aria-label=\"" + escape_html(plot.label) +
                    "\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w + "\" height=\"" + h +
                    "\" " + scale + ">\n";
  if (plot.band) {
    const double top = frame.py(plot.band->second);
    svg += "<rect class=\"band\" x=\"" + coordinate(kLeft) + "\" y=\"" + coordinate(top) +
           "\" width=\"" + coordinate(frame.width - kRight - kLeft) + "\" height=\"" +
           coordinate(std::max(1.0, frame.py(plot.band->first) - top)) + "\"/>";
  }
  svg += unseen_parts(plot, frame);
  svg += axes(plot, frame);
  for (const PlotRibbon& ribbon : plot.ribbons) svg += ribbon_group(ribbon, frame);
  for (const PlotSeries& s : plot.series) svg += series_group(s, frame);
  return svg + "<path class=\"cursor\" d=\"\"/></svg>\n";
}

}  // namespace tenter::report
