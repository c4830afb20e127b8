// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes of solid_mesh.h.
#include <cmath>
#include <cstdint>
#include <string>

#include "server/mechanics/mesh/solid_mesh.h"

namespace tenter::mechanics {

namespace {

struct Cells {
  int nx, ny, nz;
  int node(int i, int j, int k) const { return (k * (ny + 1) + j) * (nx + 1) + i; }
};

Expected<SolidMesh> box_nodes(const Cells& cells, const Eigen::Vector3d& size_m) {
  if (cells.nx < 1 || cells.ny < 1 || cells.nz < 1)
    return bad_input("box: at least one cell along each axis is needed");
  // in doubles, where nothing overflows
  const double nodes = (cells.nx + 1.0) * (cells.ny + 1.0) * (cells.nz + 1.0);
  if (nodes > kMostBoxNodes)
    return bad_input("box: more than " + std::to_string(kMostBoxNodes) + " nodes");
  if (!size_m.allFinite() || !(size_m.minCoeff() > 0.0))
    return bad_input("box: its size is not positive and finite");
  SolidMesh mesh;
  mesh.rest_m.resize(3, static_cast<Eigen::Index>(nodes));
  for (int k = 0; k <= cells.nz; ++k)
    for (int j = 0; j <= cells.ny; ++j)
      for (int i = 0; i <= cells.nx; ++i)
        mesh.rest_m.col(cells.node(i, j, k)) << size_m.x() * i / cells.nx,
            size_m.y() * j / cells.ny, size_m.z() * k / cells.nz;
  return mesh;
}

/// The cell's corners in the order of a hexahedron.
std::array<int, 8> cell(const Cells& c, int i, int j, int k) {
  return {c.node(i, j, k),
          c.node(i + 1, j, k),
          c.node(i + 1, j + 1, k),
          c.node(i, j + 1, k),
          c.node(i, j, k + 1),
          c.node(i + 1, j, k + 1),
          c.node(i + 1, j + 1, k + 1),
          c.node(i, j + 1, k + 1)};
}

/// Kuhn's six: along the axes in each order from corner 0 to corner 6, right-handed.
constexpr int kSix[6][4] = {{0, 1, 2, 6}, {0, 5, 1, 6}, {0, 2, 3, 6},
                            {0, 3, 7, 6}, {0, 4, 5, 6}, {0, 7, 4, 6}};

template <class Add>
Expected<SolidMesh> box(const Cells& cells, const Eigen::Vector3d& size_m, Add add) {
  Expected<SolidMesh> mesh = box_nodes(cells, size_m);
  if (!mesh) return mesh;
  for (int k = 0; k < cells.nz; ++k)
    for (int j = 0; j < cells.ny; ++j)
      for (int i = 0; i < cells.nx; ++i) add(*mesh, cell(cells, i, j, k));
  if (Expected<void> checked = check(*mesh); !checked) return tl::unexpected(checked.error());
  return mesh;
}

}  // namespace

Expected<SolidMesh> box_tetrahedra(int nx, int ny, int nz, const Eigen::Vector3d& size_m) {
  return box({nx, ny, nz}, size_m, [](SolidMesh& mesh, const std::array<int, 8>& c) {
    for (const auto& t : kSix)
      mesh.tetrahedra.push_back(
          {c[static_cast<std::size_t>(t[0])], c[static_cast<std::size_t>(t[1])],
           c[static_cast<std::size_t>(t[2])], c[static_cast<std::size_t>(t[3])]});
  });
}

Expected<SolidMesh> box_hexahedra(int nx, int ny, int nz, const Eigen::Vector3d& size_m) {
  return box({nx, ny, nz}, size_m,
             [](SolidMesh& mesh, const std::array<int, 8>& c) { mesh.hexahedra.push_back(c); });
}

}  // namespace tenter::mechanics
