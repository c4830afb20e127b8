// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sensors/hidden_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/estimation/sequences/material/material_locator.h"

namespace tenter::estimation {

namespace {

/// [node]: held or in a clip.
std::vector<bool> fixed_nodes(const Sequence& sequence, const mechanics::Boundary& boundary) {
  std::vector<bool> is_fixed(static_cast<std::size_t>(sequence.cloth.mesh.node_count()), false);
  for (const int node : boundary.held) is_fixed[static_cast<std::size_t>(node)] = true;
  for (const mechanics::Clip& clip : boundary.clips)
    for (const int node : clip.nodes) is_fixed[static_cast<std::size_t>(node)] = true;
  return is_fixed;
}

}  // namespace

/// Along u, so that only what is no further away in u alone is looked at.
double spacing_m(const std::vector<Eigen::Vector2d>& places_m) {
  if (places_m.size() < 2) return 0.0;
  std::vector<Eigen::Vector2d> sorted = places_m;
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x(); });
  std::vector<double> nearest(sorted.size(), std::numeric_limits<double>::infinity());
  for (std::size_t a = 0; a < sorted.size(); ++a)
    for (std::size_t b = a + 1; b < sorted.size(); ++b) {
      const Eigen::Vector2d way = sorted[b] - sorted[a];
      if (way.x() > nearest[a]) break;
      nearest[a] = std::min(nearest[a], way.norm());
      nearest[b] = std::min(nearest[b], way.norm());
    }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

std::vector<std::vector<double>> hidden_distances(const Sequence& sequence) {
  const MaterialLocator locator(sequence.cloth.mesh);
  std::vector<Eigen::Vector2d> points;
  std::vector<MaterialLocation> locations;
  for (const PointChannel& point : sequence.points) {
    points.push_back(point.material_m);
    locations.push_back(locator.locate(point.material_m).value_or(MaterialLocation{}));
  }
  const double spacing = sequence.spacing_m > 0.0 ? sequence.spacing_m : spacing_m(points);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> distances;
  for (const SequenceFrame& frame : sequence.frames) {
    const auto is_fixed =
        fixed_nodes(sequence, sequence.boundaries[static_cast<std::size_t>(frame.boundary)]);
    std::vector<Eigen::Vector2d> hidden = frame.hidden_m;
    std::vector<bool> is_seen(points.size(), false);
    for (std::size_t k = 0; k < points.size(); ++k) {
      is_seen[k] = !frame.points_m.col(static_cast<Eigen::Index>(k)).array().isNaN().all();
      const bool is_misread =
          std::ranges::find(frame.misread, static_cast<int>(k)) != frame.misread.end();
      if (!is_seen[k] && !is_misread && !locations[k].lies_on(is_fixed))
        hidden.push_back(points[k]);
    }
    auto& of_frame = distances.emplace_back(points.size(), kNone);
    for (std::size_t k = 0; k < points.size(); ++k)
      for (const Eigen::Vector2d& place : hidden)
        if (is_seen[k] && spacing > 0.0)
          of_frame[k] = std::min(of_frame[k], (points[k] - place).norm() / spacing);
  }
  return distances;
}

double drawn_share(double distance, double reach) {
  if (!(reach > 0.0)) return 0.0;
  return std::clamp((1.25 - distance / reach) / 0.5, 0.0, 1.0);
}

}  // namespace tenter::estimation
