// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of cloth with a model, flat states and loads: what tests of equilibrium start from.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::mechanics::testing {

/// The preset with other values of some terms' first parameters.
model::Model preset_with(const std::string& name,
                         std::initializer_list<std::pair<std::string, double>> values);

/// Terms with the linear law: (strain, k).
model::Model linear_model(std::initializer_list<std::pair<std::string, double>> strains);

/// All parameters of a model in order.
Eigen::VectorXd values_of(const model::Model& model);

/// Solvers refer to `model`: a sheet stays where it is.
struct Sheet {
  Sheet(Cloth of, const model::Model& description);
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  Cloth cloth;
  MeshModel model;
  Eigen::VectorXd parameters;

  int nodes() const { return cloth.mesh.node_count(); }
};

/// The same for a solid.
struct Body {
  Body(SolidMesh of, const model::Model& description);
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  SolidMesh mesh;
  MeshModel model;
  Eigen::VectorXd parameters;
};

/// Every node at (u, v, 0).
Eigen::VectorXd flat(const SurfaceMesh& mesh);
/// Every coordinate moved by up to `by`.
Eigen::VectorXd shaken(Eigen::VectorXd x, double by_m, unsigned seed);
/// Every node at place(u, v).
template <class Place>
Eigen::VectorXd placed(const SurfaceMesh& mesh, const Place& place) {
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n)
    x.segment<3>(3 * n) = place(mesh.material_m(0, n), mesh.material_m(1, n));
  return x;
}

/// Nodes whose (u, v) satisfies a predicate.
template <class Predicate>
std::vector<int> nodes_where(const SurfaceMesh& mesh, const Predicate& predicate) {
  std::vector<int> nodes;
  for (int n = 0; n < mesh.node_count(); ++n)
    if (predicate(mesh.material_m(0, n), mesh.material_m(1, n))) nodes.push_back(n);
  return nodes;
}

/// Gravity along -z on cloth of this area density.
Loads weight(const SurfaceMesh& mesh, double area_density_kg_m2);

/// Solves from `state` with a new solver; what is passed must fit. The state is the result.
EquilibriumResult solved(const MeshModel& model, const Eigen::VectorXd& parameters,
                         const Boundary& boundary, const Loads& loads, State& state,
                         const EquilibriumOptions& options = {},
                         const std::vector<Obstacle>& obstacles = {});
inline EquilibriumResult solved(const Sheet& sheet, const Boundary& boundary, const Loads& loads,
                                State& state, const EquilibriumOptions& options = {},
                                const std::vector<Obstacle>& obstacles = {}) {
  return solved(sheet.model, sheet.parameters, boundary, loads, state, options, obstacles);
}

/// log2 of the ratio of the errors of two meshes, the second twice as fine.
double order(double coarse_error, double fine_error);

}  // namespace tenter::mechanics::testing
