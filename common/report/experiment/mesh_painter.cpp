// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/mesh_painter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tenter::report {

namespace {

double dot(const Point3& a, const Point3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point3 minus(const Point3& a, const Point3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point3 normalised(const Point3& v) {
  const double length = std::sqrt(dot(v, v));
  return length > 0.0 ? Point3{v[0] / length, v[1] / length, v[2] / length} : Point3{};
}
bool is_finite(const Point3& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// Right, up and towards the eye.
struct Camera {
  Point3 right, up, eye;
  explicit Camera(const View& view)
      : right(normalised(cross(view.up, view.eye))),
        up(normalised(cross(view.eye, right))),
        eye(normalised(view.eye)) {}
  Point3 seen(const Point3& p) const { return {dot(p, right), dot(p, up), dot(p, eye)}; }
};

struct Colour {
  double red, green, blue;
};
constexpr Colour kFront = {186.0, 205.0, 226.0};
constexpr Colour kBack = {232.0, 196.0, 158.0};

struct Facet {
  std::array<Point3, 3> corners;  ///< as seen
  double depth = 0.0;             ///< larger is nearer
  std::string colour;
};

std::string shaded(const Point3& normal) {
  // normal and light as seen: the third is towards the eye
  static const Point3 light = normalised({-0.45, 0.65, 0.8});
  constexpr double kShades = 48.0;
  const double shade = std::round(kShades * (0.35 + 0.65 * std::abs(dot(normal, light)))) / kShades;
  const Colour& base = normal[2] >= 0.0 ? kFront : kBack;
  const auto level = [shade](double full) {
    return static_cast<unsigned>(std::clamp(std::lround(full * shade), 0L, 255L));
  };
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", level(base.red), level(base.green),
                level(base.blue));
  return text;
}

std::vector<Facet> facets_of(const std::vector<Point3>& points,
                             const std::vector<Corners>& triangles, const Camera& camera) {
  std::vector<Facet> facets;
  facets.reserve(triangles.size());
  for (const Corners& corners : triangles) {
    Facet facet;
    bool is_sound = true;
    for (std::size_t c = 0; c < 3 && is_sound; ++c) {
      is_sound = corners[c] >= 0 && static_cast<std::size_t>(corners[c]) < points.size() &&
                 is_finite(points[static_cast<std::size_t>(corners[c])]);
      if (!is_sound) break;
      facet.corners[c] = camera.seen(points[static_cast<std::size_t>(corners[c])]);
      facet.depth += facet.corners[c][2];
    }
    if (!is_sound) continue;
    facet.colour = shaded(normalised(cross(minus(facet.corners[1], facet.corners[0]),
                                           minus(facet.corners[2], facet.corners[0]))));
    facets.push_back(std::move(facet));
  }
  std::stable_sort(facets.begin(), facets.end(),
                   [](const Facet& a, const Facet& b) { return a.depth < b.depth; });
  return facets;
}

}  // namespace

std::optional<Extent> seen_extent(const std::vector<Point3>& points, const View& view) {
  const Camera camera(view);
  std::optional<Extent> extent;
  for (const Point3& point : points) {
    if (!is_finite(point)) continue;
    const Point3 p = camera.seen(point);
    if (!extent) extent = Extent{p[0], p[0], p[1], p[1]};
    extent->lo_x = std::min(extent->lo_x, p[0]);
    extent->hi_x = std::max(extent->hi_x, p[0]);
    extent->lo_y = std::min(extent->lo_y, p[1]);
    extent->hi_y = std::max(extent->hi_y, p[1]);
  }
  return extent;
}

std::optional<double> fitting_scale(const Extent& extent, const Canvas& canvas) {
  const double wide = extent.hi_x - extent.lo_x, high = extent.hi_y - extent.lo_y;
  if (!(std::max(wide, high) > 0.0)) return std::nullopt;
  return std::min((canvas.width - 2.0 * canvas.margin) / std::max(wide, 1e-12),
                  (canvas.height - 2.0 * canvas.margin) / std::max(high, 1e-12));
}

std::string painted_mesh(const std::vector<Point3>& points, const std::vector<Corners>& triangles,
                         const View& view, const Canvas& canvas) {
  const auto extent = seen_extent(points, view);
  if (!extent) return "";
  const auto fitting = fitting_scale(*extent, canvas);
  const std::vector<Facet> facets = facets_of(points, triangles, Camera(view));
  if (!fitting || facets.empty()) return "";
  const double scale = canvas.pixels_per_m.value_or(*fitting);
  const double x0 = 0.5 * canvas.width - 0.5 * scale * (extent->lo_x + extent->hi_x);
  const double y0 = 0.5 * canvas.height + 0.5 * scale * (extent->lo_y + extent->hi_y);
  // a thin line in the facet's colour closes the seams between neighbours; facets of one colour
  // that follow each other are one path: they show the same side, so their ways around agree
  std::string svg =
      "<g fill=\"currentColor\" stroke=\"currentColor\" stroke-width=\"0.6\" "
      "stroke-linejoin=\"round\">";
  const std::string* colour = nullptr;
  for (const Facet& facet : facets) {
    if (colour == nullptr || *colour != facet.colour) {
      svg += (colour == nullptr ? "<path color=\"" : "\"/>\n<path color=\"") + facet.colour +
             "\" d=\"";
      colour = &facet.colour;
    }
    const auto x = [&](std::size_t c) { return x0 + scale * facet.corners[c][0]; };
    const auto y = [&](std::size_t c) { return y0 - scale * facet.corners[c][1]; };
    char path[96];
    std::snprintf(path, sizeof path, "M%.1f %.1fL%.1f %.1f %.1f %.1fZ", x(0), y(0), x(1), y(1),
                  x(2), y(2));
    svg += path;
  }
  svg += "\"/>";
  return svg + "</g>\n";
}

}  // namespace tenter::report
