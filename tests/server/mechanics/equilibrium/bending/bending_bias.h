// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh does to the bending energy of its hinges.
//
// A sheet of hinges with psi = (k/2) eps_b^2, one k for all directions, should take the energy
// (3 k / 2) kappa^2 per area to be bent to a cylinder of curvature kappa, whatever the direction of
// the bend. What it does take, for small curvatures and nodes on the surface z = x' kappa x / 2, is
// a quadratic form of the curvature's three components that depends on how the sheet is cut:
//
//   E = (3 k / 2) q' Q q       q = (kappa_11, kappa_22, kappa_12)
//
//   Eigen::Matrix3d q = bending_form(mesh, {0.02, 0.08});
//   cylinder(q, angle);     // held to a cylinder: 1 would be without bias
//   free_strip(q, angle);   // of a strip that may twist and bend across
//
// Pure functions.
#pragma once

#include <Eigen/Core>

#include "common/base/error.h"
#include "server/mechanics/mesh/grid.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics::testing {

/// From the hinges whose middle lies in lo <= u < hi and lo <= v < hi: exact for a grid where that
/// is a whole number of periods.
struct Window {
  double lo_m = 0.0;
  double hi_m = 0.0;
};
Eigen::Matrix3d bending_form(const SurfaceMesh& mesh, const Window& window);

/// Of a cylinder bent in the direction at this angle from the weft.
double cylinder(const Eigen::Matrix3d& form, double angle_rad);
/// The same where nothing but that bend is imposed: bending couples to twist where this is less.
double free_strip(const Eigen::Matrix3d& form, double angle_rad);

/// A strip of 100 mm, `cells` long and `across` wide, solved under a small weight: the stiffness a
/// width that its deflection w L^4 / (8 EI) tells, over 3 k. What nodes do between the samples of a
/// smooth surface is in it.
Expected<double> strip_stiffness(int cells, int across, Diagonals diagonals, double membrane_N_m);

}  // namespace tenter::mechanics::testing
