// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material/captured_material.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "server/estimation/sequences/material/grid_layout.h"
#include "server/estimation/sequences/material/material_locator.h"
#include "server/mechanics/mesh/outline.h"

namespace tenter::estimation {

namespace {

using capture::Sheet;
using capture::Vec2;

constexpr double kClose = 1e-6;          // of the material's extent
constexpr double kMostGapOfGrid = 0.01;  // of its area, that the capture's mesh may leave open

Eigen::Vector2d place_of(const Vec2& place) {
  return {place[0], place[1]};
}

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %";
}

double close_to(const mechanics::SurfaceMesh& mesh) {
  const Eigen::Vector2d size =
      mesh.material_m.rowwise().maxCoeff() - mesh.material_m.rowwise().minCoeff();
  return kClose * size.maxCoeff();
}

Expected<mechanics::SurfaceMesh> mesh_of(const Sheet& sheet) {
  if (sheet.triangles.empty())
    return bad_input("the capture has points without triangles, so no mesh of its own");
  Eigen::Matrix2Xd material(2, static_cast<Eigen::Index>(sheet.vertex_count()));
  for (std::size_t k = 0; k < sheet.vertex_count(); ++k)
    material.col(static_cast<Eigen::Index>(k)) = place_of(sheet.material_m[k]);
  return mechanics::make_surface_mesh(std::move(material), sheet.triangles);
}

/// The rectangle that a captured mesh fills, or what speaks against it.
Expected<std::pair<Eigen::Vector2d, Eigen::Vector2d>> rectangle_of(const Sheet& sheet) {
  const auto mesh = mesh_of(sheet);
  if (!mesh)
    return bad_input(mesh.error().message +
                     "; an outline or a rectangle of the material must be given");
  const Eigen::Vector2d lo = mesh->material_m.rowwise().minCoeff();
  const Eigen::Vector2d hi = mesh->material_m.rowwise().maxCoeff();
  const std::vector<double> areas = mechanics::triangle_areas_m2(*mesh);
  const double share = std::accumulate(areas.begin(), areas.end(), 0.0) / (hi - lo).prod();
  if (!(std::abs(share - 1.0) <= kMostGapOfGrid))
    return bad_input("the captured mesh fills " + percent(share) +
                     " of its rectangle, so a grid would be another specimen; its own mesh can be "
                     "simulated");
  return std::pair(lo, hi);
}

/// Corners of a box of the material, two each at its lowest and highest coordinates?
bool is_box(const std::vector<Vec2>& outline, const Eigen::Vector2d& lo,
            const Eigen::Vector2d& hi) {
  if (outline.size() != 4) return false;
  const double close_m = kClose * (hi - lo).maxCoeff();
  const auto is_at = [close_m](double value, double end) {
    return std::abs(value - end) <= close_m;
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2& at = outline[k];
    const Vec2& next = outline[(k + 1) % 4];
    if (!is_at(at[0], lo.x()) && !is_at(at[0], hi.x())) return false;
    if (!is_at(at[1], lo.y()) && !is_at(at[1], hi.y())) return false;
    if (is_at(at[0], next[0]) == is_at(at[1], next[1])) return false;  // neither or both change
  }
  return true;
}

/// Triangles inside an outline, of the size that the cells of a square with its area would have.
Expected<mechanics::Cloth> cloth_inside(const std::vector<Vec2>& corners, int nodes_u) {
  std::vector<Eigen::Vector2d> outline;
  double twice_area = 0.0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d a = place_of(corners[k]);
    const Eigen::Vector2d b = place_of(corners[(k + 1) % corners.size()]);
    twice_area += a.x() * b.y() - a.y() * b.x();
    outline.push_back(a);
  }
  if (nodes_u < 2) return bad_input("a mesh needs two nodes along a side at least");
  const double edge_m = std::sqrt(0.5 * std::abs(twice_area)) / (nodes_u - 1);
  auto mesh = mechanics::triangulate_outline(outline, edge_m);
  if (!mesh) return tl::unexpected(mesh.error());
  return mechanics::cloth_of_mesh(std::move(*mesh));
}

/// The ends of clips and the edges of tables in these frames.
SpecimenLayout layout_of(const Sheet& sheet, const std::vector<std::size_t>& frames) {
  SpecimenLayout layout;
  for (const capture::ClipTrack& clip : sheet.clips) {
    auto& corners = layout.clips_m.emplace_back();
    for (const Vec2& corner : clip.region_m) corners.push_back(place_of(corner));
    if (!corners.empty() || clip.vertices.empty()) continue;
    Eigen::Vector2d lo = place_of(sheet.material_m[static_cast<std::size_t>(clip.vertices[0])]);
    Eigen::Vector2d hi = lo;
    for (const int vertex : clip.vertices) {
      lo = lo.cwiseMin(place_of(sheet.material_m[static_cast<std::size_t>(vertex)]));
      hi = hi.cwiseMax(place_of(sheet.material_m[static_cast<std::size_t>(vertex)]));
    }
    corners = {lo, {hi.x(), lo.y()}, hi, {lo.x(), hi.y()}};
  }
  for (const capture::SupportTrack& support : sheet.supports)
    for (const std::size_t f : frames)
      layout.edges.push_back(
          {support.along == 'u' ? 0 : 1, support.edge_m[f], support.bears_above});
  return layout;
}

bool are_alike(const std::vector<double>& lines) {
  const double cell = (lines.back() - lines.front()) / static_cast<double>(lines.size() - 1);
  for (std::size_t k = 1; k < lines.size(); ++k)
    if (std::abs(lines[k] - lines[k - 1] - cell) > kClose * cell) return false;
  return true;
}

}  // namespace

mechanics::Pose pose_of(const capture::RigidPose& pose) {
  const auto& [w, x, y, z] = pose.rotation;
  return {Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix(),
          vector_of(pose.position_m)};
}

Expected<mechanics::Cloth> cloth_of(const Sheet& sheet, const FromCaptureOptions& options,
                                    const std::vector<std::size_t>& frames, bool& is_graded) {
  is_graded = false;
  if (options.use_own_mesh) {
    auto mesh = mesh_of(sheet);
    if (!mesh) return tl::unexpected(mesh.error());
    return mechanics::cloth_of_mesh(std::move(*mesh));
  }
  auto rectangle = options.rectangle_m;
  if (!rectangle && !sheet.outline_m.empty()) {
    Eigen::Vector2d lo = place_of(sheet.outline_m.front()), hi = lo;
    for (const Vec2& corner : sheet.outline_m) {
      lo = lo.cwiseMin(place_of(corner));
      hi = hi.cwiseMax(place_of(corner));
    }
    if (!is_box(sheet.outline_m, lo, hi)) return cloth_inside(sheet.outline_m, options.nodes_u);
    rectangle = {lo, hi};
  }
  if (!rectangle) {
    auto own = rectangle_of(sheet);
    if (!own) return tl::unexpected(own.error());
    rectangle = *own;
  }
  const auto& [lo, hi] = *rectangle;
  const Eigen::Vector2d size = hi - lo;
  int nodes_u = options.nodes_u, nodes_v = options.nodes_v;
  if (nodes_v == 0 && nodes_u > 1 && size.minCoeff() > 0.0) {
    const double edge_m = std::sqrt(size.prod()) / (nodes_u - 1);
    const auto nodes = [&](double length_m) {
      return static_cast<int>(
                 std::clamp(std::round(length_m / edge_m), 1.0, 1.0 * mechanics::kMostGridNodes)) +
             1;
    };
    nodes_u = nodes(size.x());
    nodes_v = nodes(size.y());
  }
  if (options.is_graded) {
    SpecimenLayout layout = layout_of(sheet, frames);
    layout.lo_m = lo;
    layout.hi_m = hi;
    const auto lines = grid_layout(layout, {nodes_u, nodes_v});
    if (!lines) return tl::unexpected(lines.error());
    is_graded = !are_alike(lines->u_m) || !are_alike(lines->v_m);
    if (is_graded) return mechanics::cloth_of_grid(*lines, options.diagonals);
  }
  auto cloth = mechanics::cloth_of_grid({nodes_u, nodes_v, size.x(), size.y()}, options.diagonals);
  if (cloth) cloth->mesh.material_m.colwise() += lo;
  return cloth;
}

bool contains(const std::vector<Vec2>& region_m, const Eigen::Vector2d& material_m,
              double close_m) {
  bool is_inside = false;
  for (std::size_t k = 0; k < region_m.size(); ++k) {
    const Eigen::Vector2d a = place_of(region_m[k]);
    const Eigen::Vector2d b = place_of(region_m[(k + 1) % region_m.size()]);
    const Eigen::Vector2d along = b - a;
    const double length2 = along.squaredNorm();
    const double share =
        length2 > 0.0 ? std::clamp((material_m - a).dot(along) / length2, 0.0, 1.0) : 0.0;
    if ((material_m - a - share * along).norm() <= close_m) return true;
    if ((a.y() > material_m.y()) == (b.y() > material_m.y())) continue;
    const double crossing = a.x() + (material_m.y() - a.y()) / (b.y() - a.y()) * along.x();
    if (material_m.x() < crossing) is_inside = !is_inside;
  }
  return is_inside;
}

Expected<std::vector<std::vector<int>>> clamped_nodes(const Sheet& sheet,
                                                      const mechanics::SurfaceMesh& mesh,
                                                      bool is_own_mesh) {
  std::vector<std::vector<int>> nodes(sheet.clips.size());
  const double close_m = close_to(mesh);
  std::optional<mechanics::SurfaceMesh> captured;
  std::optional<MaterialLocator> locator;
  std::vector<int> owner(static_cast<std::size_t>(mesh.node_count()), -1);
  for (std::size_t c = 0; c < sheet.clips.size(); ++c) {
    const capture::ClipTrack& clip = sheet.clips[c];
    if (!clip.vertices.empty() && !is_own_mesh && !locator) {
      auto made = mesh_of(sheet);
      if (!made) return tl::unexpected(made.error());
      captured.emplace(std::move(*made));
      locator.emplace(*captured);
    }
    std::vector<bool> has_vertex(sheet.vertex_count(), false);
    for (const int vertex : clip.vertices) has_vertex[static_cast<std::size_t>(vertex)] = true;
    const auto is_clamped = [&](int node) {
      const Eigen::Vector2d place = mesh.material_m.col(node);
      if (clip.vertices.empty()) return contains(clip.region_m, place, close_m);
      if (is_own_mesh) return static_cast<bool>(has_vertex[static_cast<std::size_t>(node)]);
      const auto at = locator->locate(place);
      if (!at) return false;
      for (std::size_t a = 0; a < 3; ++a)
        if (std::abs(at->weight[a]) > kClose && !has_vertex[static_cast<std::size_t>(at->nodes[a])])
          return false;
      return true;
    };
    for (int node = 0; node < mesh.node_count(); ++node) {
      if (!is_clamped(node)) continue;
      int& of = owner[static_cast<std::size_t>(node)];
      if (of >= 0)
        return bad_input("clips \"" + sheet.clips[static_cast<std::size_t>(of)].id + "\" and \"" +
                         clip.id + "\" clamp the same node of the simulated mesh");
      of = static_cast<int>(c);
      nodes[c].push_back(node);
    }
    if (nodes[c].empty())
      return bad_input("clip \"" + clip.id +
                       "\" clamps no node of the simulated mesh; a finer one may have some there");
  }
  return nodes;
}

std::vector<bool> vertices_in_clips(const Sheet& sheet, const mechanics::SurfaceMesh& mesh) {
  const double close_m = close_to(mesh);
  std::vector<bool> is_in(sheet.vertex_count(), false);
  for (const capture::ClipTrack& clip : sheet.clips) {
    for (const int vertex : clip.vertices) is_in[static_cast<std::size_t>(vertex)] = true;
    if (!clip.region_m.empty())
      for (std::size_t k = 0; k < sheet.vertex_count(); ++k)
        if (contains(clip.region_m, place_of(sheet.material_m[k]), close_m)) is_in[k] = true;
  }
  return is_in;
}

HeldNodes held_nodes(const Sheet& sheet, std::size_t frame, const mechanics::SurfaceMesh& mesh,
                     const std::vector<bool>& is_clamped, bool clamps_at_edge) {
  HeldNodes held;
  const double close_m = close_to(mesh);
  const auto nodes = static_cast<std::size_t>(mesh.node_count());
  std::vector<const capture::SupportTrack*> bearer(nodes, nullptr);  // the first one that bears it
  std::vector<double> beyond(nodes);                                 // the edge, on its side
  for (const capture::SupportTrack& support : sheet.supports) {
    const double sign = support.bears_above ? 1.0 : -1.0;
    for (std::size_t n = 0; n < nodes; ++n) {
      const double at = mesh.material_m(support.along == 'u' ? 0 : 1, static_cast<int>(n));
      beyond[n] = sign * (at - support.edge_m[frame]);
    }
    const auto hold = [&](std::size_t n) {
      if (!bearer[n]) bearer[n] = &support;
    };
    for (std::size_t n = 0; n < nodes; ++n)
      if (beyond[n] >= -close_m) hold(n);
    if (!clamps_at_edge) continue;
    for (const auto& triangle : mesh.triangles) {
      const auto on = [&](int n) { return beyond[static_cast<std::size_t>(n)] > close_m; };
      if (std::any_of(triangle.begin(), triangle.end(), on))
        for (const int n : triangle) hold(static_cast<std::size_t>(n));
    }
  }
  std::vector<Eigen::Vector3d> places;
  for (int node = 0; node < mesh.node_count(); ++node) {
    const auto n = static_cast<std::size_t>(node);
    if (is_clamped[n] || !bearer[n]) continue;
    held.nodes.push_back(node);
    places.push_back(pose_of(bearer[n]->pose[frame])
                         .to_space({mesh.material_m(0, node), mesh.material_m(1, node), 0.0}));
  }
  held.place_m.resize(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k)
    held.place_m.col(static_cast<Eigen::Index>(k)) = places[k];
  return held;
}

std::vector<int> spread_evenly(const std::vector<Vec2>& material_m,
                               const std::vector<int>& candidates, int count) {
  if (count <= 0 || candidates.size() <= static_cast<std::size_t>(count)) return candidates;
  const auto place = [&](std::size_t k) {
    return place_of(material_m[static_cast<std::size_t>(candidates[k])]);
  };
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < candidates.size(); ++k) middle += place(k);
  middle /= static_cast<double>(candidates.size());
  std::size_t next = 0;
  for (std::size_t k = 1; k < candidates.size(); ++k)
    if ((place(k) - middle).squaredNorm() < (place(next) - middle).squaredNorm()) next = k;
  std::vector<double> distance2(candidates.size(), std::numeric_limits<double>::infinity());
  std::vector<int> chosen;
  while (chosen.size() < static_cast<std::size_t>(count)) {
    chosen.push_back(candidates[next]);
    const Eigen::Vector2d last = place(next);
    for (std::size_t k = 0; k < candidates.size(); ++k)
      distance2[k] = std::min(distance2[k], (place(k) - last).squaredNorm());
    next = static_cast<std::size_t>(std::max_element(distance2.begin(), distance2.end()) -
                                    distance2.begin());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace tenter::estimation
