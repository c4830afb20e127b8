// SPDX-License-Identifier: GPL-3.0-or-later
// Distorted boxes of tetrahedra, of hexahedra and of both, and their deformed states.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "server/mechanics/mesh/solid_mesh.h"
#include "tests/server/mechanics/random_solids.h"

namespace tenter::mechanics {

inline const Eigen::Vector3d kBoxSize(0.15, 0.1, 0.1);
constexpr double kCell = 0.05;

inline bool on_boundary(const Eigen::Vector3d& place_m) {
  return !(place_m.array() > 1e-9).all() || !((kBoxSize - place_m).array() > 1e-9).all();
}

/// Inner nodes moved by up to a fifth of a cell.
inline SolidMesh distorted(SolidMesh mesh, unsigned seed) {
  tenter::testing::Numbers numbers(seed);
  for (int n = 0; n < mesh.node_count(); ++n)
    if (!on_boundary(mesh.rest_m.col(n)))
      for (int i = 0; i < 3; ++i) mesh.rest_m(i, n) += numbers.between(-0.2, 0.2) * kCell;
  return mesh;
}

/// Hexahedra but for the cells of its last third, which are six tetrahedra each.
inline SolidMesh mixed_box() {
  SolidMesh mesh = box_hexahedra(3, 2, 2, kBoxSize).value();
  const SolidMesh cut = box_tetrahedra(3, 2, 2, kBoxSize).value();
  std::vector<std::array<int, 8>> kept;
  for (std::size_t h = 0; h < mesh.hexahedra.size(); ++h) {
    if (h % 3 != 2)
      kept.push_back(mesh.hexahedra[h]);
    else
      for (std::size_t t = 6 * h; t < 6 * h + 6; ++t) mesh.tetrahedra.push_back(cut.tetrahedra[t]);
  }
  mesh.hexahedra = std::move(kept);
  return mesh;
}

struct SolidBody {
  std::string name;
  SolidMesh mesh;
};

inline std::vector<SolidBody> solid_bodies() {
  return {{"tetrahedra", distorted(box_tetrahedra(3, 2, 2, kBoxSize).value(), 1)},
          {"hexahedra", distorted(box_hexahedra(3, 2, 2, kBoxSize).value(), 2)},
          {"both", distorted(mixed_box(), 3)}};
}

/// x = F X + c.
inline Eigen::VectorXd affine(const SolidMesh& mesh, const Eigen::Matrix3d& f,
                              const Eigen::Vector3d& c = Eigen::Vector3d::Zero()) {
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) x.segment<3>(3 * n) = f * mesh.rest_m.col(n) + c;
  return x;
}

/// A large affine deformation, and every node off it by up to `by` of a cell.
inline Eigen::VectorXd deformed(const SolidMesh& mesh, double by, unsigned seed) {
  tenter::testing::Numbers numbers(seed);
  Eigen::VectorXd x = affine(mesh, tenter::testing::random_solid(numbers));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += numbers.between(-by, by) * kCell;
  return x;
}

}  // namespace tenter::mechanics
