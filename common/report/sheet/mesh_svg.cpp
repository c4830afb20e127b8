// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/mesh_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "common/report/html_parts.h"
#include "common/report/html_text.h"
#include "common/report/sheet/document.h"
#include "common/report/words.h"

namespace tenter::report::sheet {

namespace {

using Point = std::array<double, 3>;

constexpr double kWidth = 560.0;
constexpr double kMargin = 16.0;
constexpr double kMostHeight = 460.0;
constexpr double kLegend = 34.0;
constexpr int kColours = 10;

std::optional<Point> point(const Json& value) {
  if (!value.is_array() || value.size() != 3) return std::nullopt;
  Point p{};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::optional<double> x = number(value[c]);
    if (!x) return std::nullopt;
    p[c] = *x;
  }
  return p;
}

std::vector<Point> points(const Json& object, const char* key) {
  std::vector<Point> all;
  for (const Json& value : list(object, key)) {
    const std::optional<Point> p = point(value);
    if (!p) return {};
    all.push_back(*p);
  }
  return all;
}

struct Face {
  std::array<std::size_t, 3> corners{};
  std::optional<double> residual;  ///< mean over its corners that have one
};

std::vector<Face> faces(const Json& mesh, std::size_t nodes) {
  const Json& residuals = list(mesh, "residual_m");
  std::vector<Face> all;
  for (const Json& triangle : list(mesh, "triangles")) {
    if (!triangle.is_array() || triangle.size() != 3) continue;
    Face face;
    double sum = 0.0;
    int seen = 0;
    bool sound = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::optional<double> node = number(triangle[a]);
      sound = sound && node && *node >= 0.0 && *node < static_cast<double>(nodes);
      if (!sound) break;
      face.corners[a] = static_cast<std::size_t>(*node);
      if (face.corners[a] >= residuals.size()) continue;
      if (const std::optional<double> r = number(residuals[face.corners[a]])) {
        sum += *r;
        ++seen;
      }
    }
    if (!sound) continue;
    if (seen > 0) face.residual = sum / seen;
    all.push_back(face);
  }
  return all;
}

/// Where a point of space lies in the picture.
struct View {
  int across = 0, up = 1, along = 2;  ///< axes of space; it is seen along the last
  double scale = 1.0, x0 = 0.0, y0 = 0.0;
  double height = 0.0;

  double px(const Point& p) const {
    return kMargin + scale * (p[static_cast<std::size_t>(across)] - x0);
  }
  double py(const Point& p) const {
    return kMargin + scale * (y0 - p[static_cast<std::size_t>(up)]);
  }
  double depth(const Point& p) const { return p[static_cast<std::size_t>(along)]; }
};

std::optional<View> view_of(const std::vector<Point>& all) {
  Point lo = all.front();
  Point hi = all.front();
  for (const Point& p : all)
    for (std::size_t c = 0; c < 3; ++c) {
      lo[c] = std::min(lo[c], p[c]);
      hi[c] = std::max(hi[c], p[c]);
    }
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const auto i = static_cast<std::size_t>(a);
    const auto j = static_cast<std::size_t>(b);
    return hi[i] - lo[i] > hi[j] - lo[j];
  });
  View view;
  // x to the right and z up where they are shown
  view.across = std::min(order[0], order[1]);
  view.up = std::max(order[0], order[1]);
  view.along = order[2];
  const auto a = static_cast<std::size_t>(view.across);
  const auto u = static_cast<std::size_t>(view.up);
  const double wide = hi[a] - lo[a];
  const double high = hi[u] - lo[u];
  if (!(std::max(wide, high) > 0.0) || !std::isfinite(wide + high)) return std::nullopt;
  view.scale = std::min((kWidth - 2.0 * kMargin) / std::max(wide, 1e-300),
                        (kMostHeight - 2.0 * kMargin) / std::max(high, 1e-300));
  view.x0 = lo[a] - ((kWidth - 2.0 * kMargin) / view.scale - wide) / 2.0;
  view.y0 = hi[u];
  view.height = view.scale * high + 2.0 * kMargin;
  return view;
}

std::string coordinates(double x, double y) {
  char words[64];
  std::snprintf(words, sizeof words, "%.1f %.1f", x, y);
  return words;
}

std::string face_path(const Face& face, const std::vector<Point>& nodes, const View& view,
                      double full) {
  std::string css = "unmeasured";
  if (face.residual) {
    const int step = full > 0.0 ? static_cast<int>(kColours * *face.residual / full) : 0;
    css = "s" + std::to_string(std::clamp(step, 0, kColours - 1));
  }
  std::string d;
  for (const std::size_t corner : face.corners)
    d += (d.empty() ? "M" : "L") + coordinates(view.px(nodes[corner]), view.py(nodes[corner]));
  return "<path class=\"face " + css + "\" d=\"" + d + "Z\"/>";
}

/// A line with two short strokes at its end.
std::string arrow(double x, double y, double dx, double dy) {
  const double length = std::hypot(dx, dy);
  if (!(length > 0.3) || !std::isfinite(length)) return "";
  std::string d = "M" + coordinates(x, y) + "l" + coordinates(dx, dy);
  const double barb = std::min(4.0, 0.4 * length) / length;
  for (const double side : {-0.5, 0.5})
    d += "M" + coordinates(x + dx, y + dy) + "l" +
         coordinates(barb * (-dx - side * dy), barb * (-dy + side * dx));
  return d;
}

std::string arrows(const Json& mesh, const View& view) {
  std::string d;
  for (const Json& entry : list(mesh, "arrows")) {
    const std::optional<Point> at = point(member(entry, "at_m"));
    const std::optional<Point> by = point(member(entry, "residual_m"));
    if (!at || !by) continue;
    const double scale = kArrowScale * view.scale;
    d += arrow(view.px(*at), view.py(*at), scale * (*by)[static_cast<std::size_t>(view.across)],
               -scale * (*by)[static_cast<std::size_t>(view.up)]);
  }
  return d.empty() ? "" : "<path class=\"arrow\" d=\"" + d + "\"/>\n";
}

std::string legend(double full, std::optional<double> sigma, double top) {
  constexpr double kBox = 18.0;
  std::string svg;
  for (int c = 0; c < kColours; ++c) {
    char rect[120];
    std::snprintf(rect, sizeof rect,
                  "<rect class=\"bar s%d\" x=\"%g\" y=\"%.1f\" width=\"%g\" height=\"9\"/>", c,
                  kMargin + kBox * c, top, kBox);
    svg += rect;
  }
  const auto label = [&](double x, const char* anchor, const std::string& words) {
    char place[96];
    std::snprintf(place, sizeof place, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x,
                  top + 22.0, anchor);
    svg += place + words + "</text>";
  };
  label(kMargin, "start", "0");
  label(kMargin + kBox * kColours, "end", quantity(full, "m"));
  label(kWidth - kMargin, "end",
        "residual" + (sigma ? "; \u03c3 " + quantity(sigma, "m") : std::string()));
  return svg;
}

std::string mesh_figure(const Json& mesh, const std::string& heading) {
  const std::string svg = mesh_svg(mesh);
  if (svg.empty()) return "";
  const std::optional<double> frame = number(mesh, "frame");
  return "<figure class=\"sheet\">\n<div class=\"over\">" + heading +
         "</div>\n<figcaption><span>frame " + significant(frame) + ": " +
         escape_html(text(mesh, "why")) + "</span><span class=\"readout\">rms " +
         quantity(number(mesh, "rms_m"), "m") + "</span></figcaption>\n" + svg + "</figure>\n";
}

}  // namespace

std::string mesh_svg(const Json& mesh) {
  const std::vector<Point> nodes = points(mesh, "position_m");
  if (nodes.size() < 3) return "";
  const std::vector<Face> all = faces(mesh, nodes.size());
  const std::optional<View> view = view_of(nodes);
  if (all.empty() || !view) return "";
  double full = 0.0;
  for (const Face& face : all) full = std::max(full, face.residual.value_or(0.0));

  const auto depth = [&](std::size_t f) {
    double sum = 0.0;
    for (const std::size_t corner : all[f].corners) sum += view->depth(nodes[corner]);
    return sum;
  };
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0U);
  // along y the eye is in front, at negative y; along x and z it is at the positive end
  const double towards_eye = view->along == 1 ? -1.0 : 1.0;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return towards_eye * depth(a) < towards_eye * depth(b);
  });

  constexpr const char* kAxes = "xyz";
  char head[320];
  std::snprintf(head, sizeof head,
                "<svg class=\"mesh\" role=\"img\" viewBox=\"0 0 %g %.1f\" width=\"%g\" "
                "height=\"%.1f\" aria-label=\"the deformed sheet, %c to the right and %c up, "
                "coloured by residual\">\n<g class=\"series\">",
                kWidth, view->height + kLegend, kWidth, view->height + kLegend, kAxes[view->across],
                kAxes[view->up]);
  std::string svg = head;
  for (const std::size_t f : order) svg += face_path(all[f], nodes, *view, full);
  svg += "</g>\n" + arrows(mesh, *view) + legend(full, number(mesh, "sigma_m"), view->height);
  return svg + "</svg>\n";
}

std::string mesh_section(const Json& result) {
  std::string figures;
  for (const Json& mesh : list(result, "meshes")) {
    std::string heading = escape_html(text(mesh, "title"));
    for (const Json& capture : list(result, "captures")) {
      if (text(capture, "id") != text(mesh, "capture")) continue;
      if (flag(capture, "synthetic")) heading += " " + badge("synthetic", "SYNTHETIC");
      if (flag(capture, "held_out")) heading += " " + badge("named", "HELD OUT");
    }
    figures += mesh_figure(mesh, heading);
  }
  if (figures.empty()) return "";
  return "<section id=\"sheets\">\n<h2>The sheet</h2>\n<p class=\"soft\">The fitted model's sheet, "
         "coloured by how far the measured material is from it; arrows point to the measurement, "
         "five times their length.</p>\n<div class=\"figures\">\n" +
         figures + "</div>\n</section>\n";
}

}  // namespace tenter::report::sheet
