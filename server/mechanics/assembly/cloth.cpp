// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/cloth.h"

#include <utility>

namespace tenter::mechanics {

Expected<Cloth> cloth_of_grid(const Grid& grid, Diagonals diagonals) {
  if (auto good = check(grid); !good) return tl::unexpected(good.error());
  return cloth_of_grid(lines_of(grid), diagonals);
}

Expected<Cloth> cloth_of_grid(const GridLines& grid, Diagonals diagonals) {
  auto mesh = grid_mesh(grid, diagonals);
  if (!mesh) return tl::unexpected(mesh.error());
  auto springs = grid_springs(grid);
  if (!springs) return tl::unexpected(springs.error());
  std::vector<Hinge> list = hinges(*mesh);
  return Cloth{std::move(*mesh), std::move(list), std::move(*springs)};
}

Expected<Cloth> cloth_of_mesh(SurfaceMesh mesh) {
  if (auto good = check(mesh); !good) return tl::unexpected(good.error());
  std::vector<Hinge> list = hinges(mesh);
  Springs springs = mesh_springs(mesh);
  return Cloth{std::move(mesh), std::move(list), std::move(springs)};
}

}  // namespace tenter::mechanics
