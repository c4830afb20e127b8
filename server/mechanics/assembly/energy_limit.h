// SPDX-License-Identifier: GPL-3.0-or-later
// Energy constraints of thesis (4.5), C = Psi_max - Psi_i(X) >= 0, on the elements of a mesh, as an
// augmented Lagrangian (Powell, Hestenes, Rockafellar). Each element of measure m and limited
// density psi, with its multiplier l >= 0 and the penalty mu, adds to the energy
//
//   m/(2 mu) (a^2 - l^2)     a = max(0, l + mu (psi - psi_max))
//   gradient  m a dpsi       stiffness  m (a d2psi + mu dpsi dpsi')   where a > 0
//
// which has a continuous slope. Minimised over x and then l <- a, in turn, it comes to the
// constrained minimum, where l >= 0, psi <= psi_max and one of them is an equality: there the
// limited terms answer as if 1 + l times as stiff. Where a single element of quadratic energy bears
// the load, a turn shrinks the error of l about 2 mu psi_max/(1 + l) times; a larger mu takes fewer
// turns and gives a stiffer matrix.
//
//   EnergyLimitState limits{Eigen::VectorXd::Zero(model.limited_count()), 10.0 / psi_max};
//   do {
//     ... minimise evaluate(x, p, output, &limits) over x ...
//     status = model.limit_excess(x, p, excess);
//   } while (update_multipliers(excess, limits) > tolerance);
//
// A limit holds on terms without memory: one that names a term whose law remembers its path is
// refused, and one on all terms leaves those out.
//
// Data of the caller; one state a frame, kept from solve to solve as a warm start.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/mechanics/assembly/term_strains.h"

namespace tenter::mechanics {

/// The elements of one kind that one limit holds on; quadrature points count as elements.
struct LimitedElements {
  std::string limit;        ///< its id
  double energy_max = 0.0;  ///< psi_max, J/m^2 or J/m^3
  ElementKind kind = ElementKind::triangle;
  int first = 0;                ///< of their entries in multipliers and excesses
  std::vector<int> element;     ///< numbers, as in TermStrains
  std::vector<double> measure;  ///< m: m^2 or m^3 at rest
};

struct EnergyLimitState {
  Eigen::VectorXd multiplier;  ///< l: one an entry, limited_count() of them, without unit
  double penalty = 0.0;        ///< mu > 0, 1/(J/m^2) or 1/(J/m^3)
};

/// The elements whose limit is active (a > 0) and how their limited density changes.
struct ActiveLimits {
  std::vector<int> entry;        ///< places in multipliers and excesses, ascending
  Eigen::MatrixXd by_x;          ///< dpsi/dx: (3 nodes) x active
  Eigen::MatrixXd by_parameter;  ///< dpsi/dp: active x parameters
};

/// l <- max(0, l + mu excess), with psi - psi_max from MeshModel::limit_excess at the minimum.
/// Returns the largest change of a multiplier: zero at the constrained minimum.
double update_multipliers(const Eigen::VectorXd& excess, EnergyLimitState& state);

}  // namespace tenter::mechanics
