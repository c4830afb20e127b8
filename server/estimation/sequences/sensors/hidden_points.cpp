// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sensors/hidden_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/estimation/sequences/material/material_locator.h"

namespace tenter::estimation {

namespace {

/// [point]: those within 1.5 times the spacing.
std::vector<std::vector<std::size_t>> neighbours_of(const std::vector<PointChannel>& points) {
  constexpr double kReach = 1.5;
  const auto distance = [&](std::size_t a, std::size_t b) {
    return (points[a].material_m - points[b].material_m).norm();
  };
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t a = 0; a < points.size(); ++a)
    for (std::size_t b = 0; b < points.size(); ++b)
      if (a != b) nearest[a] = std::min(nearest[a], distance(a, b));
  std::vector<std::vector<std::size_t>> neighbours(points.size());
  if (points.size() < 2) return neighbours;
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  for (std::size_t a = 0; a < points.size(); ++a)
    for (std::size_t b = 0; b < points.size(); ++b)
      if (a != b && distance(a, b) <= kReach * *middle) neighbours[a].push_back(b);
  return neighbours;
}

/// [node]: held or in a clip.
std::vector<bool> fixed_nodes(const Sequence& sequence, const mechanics::Boundary& boundary) {
  std::vector<bool> is_fixed(static_cast<std::size_t>(sequence.cloth.mesh.node_count()), false);
  for (const int node : boundary.held) is_fixed[static_cast<std::size_t>(node)] = true;
  for (const mechanics::Clip& clip : boundary.clips)
    for (const int node : clip.nodes) is_fixed[static_cast<std::size_t>(node)] = true;
  return is_fixed;
}

}  // namespace

std::vector<std::vector<bool>> beside_hidden(const Sequence& sequence) {
  const std::size_t points = sequence.points.size();
  const auto neighbours = neighbours_of(sequence.points);
  const MaterialLocator locator(sequence.cloth.mesh);
  std::vector<MaterialLocation> places;
  for (const PointChannel& point : sequence.points)
    places.push_back(locator.locate(point.material_m).value_or(MaterialLocation{}));
  std::vector<std::vector<bool>> beside;
  for (const SequenceFrame& frame : sequence.frames) {
    const auto is_fixed =
        fixed_nodes(sequence, sequence.boundaries[static_cast<std::size_t>(frame.boundary)]);
    const auto is_seen = [&](std::size_t k) {
      return !frame.points_m.col(static_cast<Eigen::Index>(k)).array().isNaN().all();
    };
    const auto is_hidden = [&](std::size_t k) {
      bool is_held = true;
      for (std::size_t a = 0; a < 3; ++a)
        is_held = is_held && (std::abs(places[k].weight[a]) < 1e-9 ||
                              is_fixed[static_cast<std::size_t>(places[k].nodes[a])]);
      return !is_seen(k) && !is_held;
    };
    auto& of_frame = beside.emplace_back(points, false);
    for (std::size_t k = 0; k < points; ++k) {
      if (!is_hidden(k)) continue;
      for (const std::size_t other : neighbours[k])
        if (is_seen(other)) of_frame[other] = true;
    }
  }
  return beside;
}

}  // namespace tenter::estimation
