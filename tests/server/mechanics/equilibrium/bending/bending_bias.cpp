// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/equilibrium/bending/bending_bias.h"

#include <Eigen/LU>
#include <cmath>

#include "server/mechanics/equilibrium/equilibrium.h"
#include "server/mechanics/mesh/hinges.h"

namespace tenter::mechanics::testing {
namespace {

model::Model material(double membrane_N_m, double bending_N_m) {
  model::Model model;
  const std::pair<const char*, double> terms[] = {
      {"green_u", membrane_N_m}, {"green_v", membrane_N_m}, {"green_uv", membrane_N_m / 3.0},
      {"bend_u", bending_N_m},   {"bend_v", bending_N_m},   {"bend_d", bending_N_m}};
  for (const auto& [strain, k] : terms) {
    model::Term term;
    term.id = strain;
    term.strain.name = strain;
    term.law.name = "linear";
    term.law.parameters.resize(1);
    term.law.parameters[0].name = "k";
    term.law.parameters[0].value = k;
    model.terms.push_back(term);
  }
  return model;
}

}  // namespace

Eigen::Matrix3d bending_form(const SurfaceMesh& mesh, const Window& window) {
  const double size = window.hi_m - window.lo_m;
  const double small = 1e-5 / size;  // curvature: angles so small that they are linear in it
  const double edge = 1e-9 * size;   // lines of a grid are on one side, whatever their rounding
  const auto is_inside = [&](double a) {
    return a >= window.lo_m - edge && a < window.hi_m - edge;
  };
  const Eigen::Vector2d centre = Eigen::Vector2d::Constant(0.5 * (window.lo_m + window.hi_m));
  Eigen::Matrix3d form = Eigen::Matrix3d::Zero();
  for (const Hinge& hinge : hinges(mesh)) {
    const Eigen::Vector2d middle =
        0.5 * (mesh.material_m.col(hinge.nodes[0]) + mesh.material_m.col(hinge.nodes[1]));
    if (!is_inside(middle.x()) || !is_inside(middle.y())) continue;
    Eigen::Vector3d strain;  // by each component of the curvature
    for (int c = 0; c < 3; ++c) {
      Eigen::Vector3d x[4];
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d at = mesh.material_m.col(hinge.nodes[i]) - centre;
        const double z = c == 2 ? at.x() * at.y() : 0.5 * at[c] * at[c];
        x[i] << at, small * z;
      }
      strain[c] = dihedral_angle(x[0], x[1], x[2], x[3]) / hinge.height_m / small;
    }
    form += hinge.area_m2 * strain * strain.transpose();
  }
  return form / (3.0 * size * size);
}

double cylinder(const Eigen::Matrix3d& form, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const Eigen::Vector3d q(c * c, s * s, c * s);
  return q.dot(form * q);
}

double free_strip(const Eigen::Matrix3d& form, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const Eigen::Vector3d moment(c * c, s * s, 2.0 * c * s);  // its work is moment . q
  return 1.0 / moment.dot(form.inverse() * moment);
}

Expected<double> strip_stiffness(int cells, int across, Diagonals diagonals, double membrane_N_m) {
  const double bending_N_m = 1e-4, density = 0.004, length = 0.1;
  const double cell = length / (cells + 0.5);  // the clamp is half way between two held columns
  const Grid grid{cells + 2, across + 1, length + 0.5 * cell, cell * across};
  const auto cloth = cloth_of_grid(grid, diagonals);
  if (!cloth) return tl::unexpected(cloth.error());
  const auto model = MeshModel::make(material(membrane_N_m, bending_N_m), *cloth);
  if (!model) return tl::unexpected(model.error());
  Boundary boundary;
  State state;
  state.x.setZero(3 * static_cast<Eigen::Index>(grid.node_count()));
  for (int n = 0; n < grid.node_count(); ++n) {
    state.x.segment<2>(3 * static_cast<Eigen::Index>(n)) = cloth->mesh.material_m.col(n);
    if (cloth->mesh.material_m(0, n) < 1.5 * cell) boundary.held.push_back(n);
  }
  Loads loads;
  const auto mass = lumped_masses_kg(cloth->mesh, density);
  loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(mass.data(), static_cast<Eigen::Index>(mass.size()));
  Eigen::VectorXd parameters(6);
  parameters << membrane_N_m, membrane_N_m, membrane_N_m / 3.0, bending_N_m, bending_N_m,
      bending_N_m;
  auto solver = EquilibriumSolver::make(*model, boundary);
  if (!solver) return tl::unexpected(solver.error());
  EquilibriumOptions options;
  options.tolerance_N = 1e-10;
  const auto result = solver->solve(parameters, loads, state, options);
  if (!result) return tl::unexpected(result.error());
  if (!result->is_good(options)) return fail(ErrorKind::refused, describe(*result, options));
  const double drop = -state.x[3 * static_cast<Eigen::Index>(grid.node(cells + 1, across / 2)) + 2];
  const double w = density * 9.81;
  return w * std::pow(length, 4) / (8.0 * 3.0 * bending_N_m) / drop;
}

}  // namespace tenter::mechanics::testing
