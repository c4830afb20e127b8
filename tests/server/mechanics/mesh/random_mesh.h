// SPDX-License-Identifier: GPL-3.0-or-later
// Irregular sheets for properties: a grid with seeded random splittings, whose inner nodes are
// moved by up to a quarter of a cell and whose node numbers are shuffled.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "server/mechanics/mesh/grid.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::testing {

inline mechanics::SurfaceMesh random_mesh(unsigned seed, const mechanics::Grid& grid) {
  using mechanics::Diagonals;
  Numbers numbers(seed);
  const mechanics::SurfaceMesh rising = mechanics::grid_mesh(grid, Diagonals::one).value();
  const mechanics::SurfaceMesh falling = mechanics::grid_mesh(grid, Diagonals::other).value();
  std::vector<int> number(static_cast<std::size_t>(grid.node_count()));
  std::iota(number.begin(), number.end(), 0);
  for (std::size_t k = number.size(); k > 1; --k)
    std::swap(
        number[k - 1],
        number[static_cast<std::size_t>(numbers.between(0.0, 0.999999) * static_cast<double>(k))]);
  Eigen::Matrix2Xd material(2, grid.node_count());
  for (int j = 0; j < grid.nodes_v; ++j)
    for (int i = 0; i < grid.nodes_u; ++i) {
      Eigen::Vector2d place = rising.material_m.col(grid.node(i, j));
      if (i > 0 && i + 1 < grid.nodes_u) place.x() += numbers.between(-0.25, 0.25) * grid.du_m();
      if (j > 0 && j + 1 < grid.nodes_v) place.y() += numbers.between(-0.25, 0.25) * grid.dv_m();
      material.col(number[static_cast<std::size_t>(grid.node(i, j))]) = place;
    }
  std::vector<std::array<int, 3>> triangles;
  for (std::size_t cell = 0; cell < rising.triangles.size(); cell += 2) {
    const auto& source = numbers.between(0.0, 1.0) < 0.5 ? rising : falling;
    for (std::size_t k = cell; k < cell + 2; ++k) {
      std::array<int, 3> t = source.triangles[k];
      for (int& node : t) node = number[static_cast<std::size_t>(node)];
      std::rotate(t.begin(), t.begin() + static_cast<int>(numbers.between(0.0, 2.999)), t.end());
      triangles.push_back(t);
    }
  }
  auto mesh = mechanics::make_surface_mesh(material, triangles);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().message);
  return mesh.value();
}

inline double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace tenter::testing
