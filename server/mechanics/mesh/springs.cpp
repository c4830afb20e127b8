// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/springs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A line has no sense of way: angle in (-pi/2, pi/2].
double line_angle(const Eigen::Vector2d& along) {
  const double angle = std::atan2(along.y(), along.x());
  if (angle > 0.5 * kPi) return angle - kPi;
  if (angle <= -0.5 * kPi) return angle + kPi;
  return angle;
}

/// A family of parallel springs on a grid: from every node to the one `reach` steps further along
/// (step_u, step_v).
struct Family {
  int step_u;
  int step_v;
  Direction direction;
};

constexpr std::array<Family, 4> kFamilies = {{{1, 0, Direction::weft},
                                              {0, 1, Direction::warp},
                                              {1, 1, Direction::diagonal},
                                              {1, -1, Direction::diagonal}}};

/// Widths of what each spring stands for along one axis with these lines, by the index of its first
/// node along that axis (smaller one). They sum to the distance of the outermost lines.
std::vector<double> shares(const std::vector<double>& lines, int extent) {
  const std::size_t nodes = lines.size(), reach = static_cast<std::size_t>(extent);
  std::vector<double> width;
  for (std::size_t k = 0; k + reach < nodes; ++k) {
    if (extent == 1) {  // the cells themselves
      width.push_back(lines[k + 1] - lines[k]);
      continue;
    }
    // what is nearer to the line, or to the middle one of three, than to another spring's
    const std::size_t at = k + reach / 2;
    const bool is_first = k == 0, is_last = k + reach + 1 == nodes;
    const double from = is_first ? lines.front() : 0.5 * (lines[at - 1] + lines[at]);
    const double to = is_last ? lines.back() : 0.5 * (lines[at] + lines[at + 1]);
    width.push_back(to - from);
  }
  return width;
}

void add_family(const GridLines& lines, const Family& family, int reach, std::vector<Spring>& out) {
  const int nodes_u = static_cast<int>(lines.u_m.size());
  const int extent_u = family.step_u * reach;
  const int extent_v = std::abs(family.step_v) * reach;
  const std::vector<double> width_u = shares(lines.u_m, extent_u);
  const std::vector<double> width_v = shares(lines.v_m, extent_v);
  for (std::size_t j = 0; j < width_v.size(); ++j)
    for (std::size_t i = 0; i < width_u.size(); ++i) {
      const auto right = i + static_cast<std::size_t>(extent_u);
      const auto high = j + static_cast<std::size_t>(extent_v);
      const Eigen::Vector2d along(
          lines.u_m[right] - lines.u_m[i],
          (family.step_v < 0 ? -1.0 : 1.0) * (lines.v_m[high] - lines.v_m[j]));
      const auto node = [&](std::size_t column, std::size_t row) {
        return static_cast<int>(row) * nodes_u + static_cast<int>(column);
      };
      out.push_back({node(i, family.step_v < 0 ? high : j),
                     node(right, family.step_v < 0 ? j : high), along.norm(),
                     width_u[i] * width_v[j], family.direction, line_angle(along)});
    }
}

int family_of(const Spring& spring) {
  switch (spring.direction) {
    case Direction::weft:
      return 0;
    case Direction::warp:
      return 1;
    case Direction::diagonal:
      return spring.angle_rad > 0.0 ? 2 : 3;
  }
  return 0;
}

/// A pair of nodes with the unscaled share of the sheet that one edge gives it.
Spring between(const SurfaceMesh& mesh, int a, int b, double share) {
  const Eigen::Vector2d along = mesh.way_m(std::min(a, b), std::max(a, b));
  return {std::min(a, b), std::max(a, b),      along.norm(),
          share,          direction_of(along), line_angle(along)};
}

/// One spring for each pair of nodes, areas added, each family scaled to the area of the sheet.
std::vector<Spring> share_out(std::vector<Spring> springs, double sheet_m2) {
  std::stable_sort(springs.begin(), springs.end(), [](const Spring& x, const Spring& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  });
  std::vector<Spring> merged;
  for (const Spring& spring : springs) {
    if (!merged.empty() && merged.back().a == spring.a && merged.back().b == spring.b)
      merged.back().area_m2 += spring.area_m2;
    else
      merged.push_back(spring);
  }
  std::array<double, 4> total = {};
  for (const Spring& spring : merged)
    total[static_cast<std::size_t>(family_of(spring))] += spring.area_m2;
  for (Spring& spring : merged)
    spring.area_m2 *= sheet_m2 / total[static_cast<std::size_t>(family_of(spring))];
  return merged;
}

}  // namespace

Expected<Springs> grid_springs(const Grid& grid) {
  if (Expected<void> checked = check(grid); !checked) return tl::unexpected(checked.error());
  return grid_springs(lines_of(grid));
}

Expected<Springs> grid_springs(const GridLines& grid) {
  if (Expected<void> checked = check(grid); !checked) return tl::unexpected(checked.error());
  Springs springs;
  for (const Family& family : kFamilies) {
    add_family(grid, family, 1, springs.ring1);
    add_family(grid, family, 2, springs.ring2);
  }
  // a line of three nodes has one ring-2 spring, which stands for both cells: 1 + 1/2 + 1/2
  return springs;
}

Springs mesh_springs(const SurfaceMesh& mesh) {
  const std::vector<double> area = triangle_areas_m2(mesh);
  const auto third_of = [&](int triangle) {
    return triangle < 0 ? 0.0 : area[static_cast<std::size_t>(triangle)] / 3.0;
  };
  std::vector<Spring> ring1;
  std::vector<Spring> ring2;
  for (const Edge& edge : edges(mesh)) {
    const double share = third_of(edge.left_triangle) + third_of(edge.right_triangle);
    ring1.push_back(between(mesh, edge.low, edge.high, share));
    const bool apart =
        edge.interior() && !mesh.way_m(edge.left_corner, edge.right_corner).isZero(0.0);
    if (apart) ring2.push_back(between(mesh, edge.left_corner, edge.right_corner, share));
  }
  const double sheet = std::accumulate(area.begin(), area.end(), 0.0);
  return {share_out(std::move(ring1), sheet), share_out(std::move(ring2), sheet)};
}

}  // namespace tenter::mechanics
