// SPDX-License-Identifier: GPL-3.0-or-later
// Rest of a sheet whose unknowns are free but for some that stay: Newton's method with a line
// search on the energy, with a direct factor (CHOLMOD's supernodes).
//
//   SheetSolver solver(sheet, held);            // held: unknowns that do not move
//   SheetRest rest = solver.solve(x);           // x: start and result
//   if (!rest.converged) ...
//
// Far from a minimum a share of what makes the second derivative negative is left out; a result is
// one where the whole is positive definite. Shares nothing with server/. One thread.
#pragma once

#include <Eigen/CholmodSupport>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "tests/twin/fabrics/sheet/sheet.h"

namespace tenter::twin {

struct SheetRest {
  bool converged = false;  ///< no net force, and a minimum
  int iterations = 0;
  double net_force_N = 0.0;  ///< 2-norm over free unknowns
};

struct SheetTolerance {
  double net_force_N = 1e-7;
  int iterations = 400;
  double longest_move_m = 6e-3;  ///< of an unknown in one step
};

class SheetSolver {
 public:
  /// `sheet` outlives the solver.
  SheetSolver(const Sheet& sheet, const std::vector<int>& held);

  SheetRest solve(Eigen::VectorXd& x, const SheetTolerance& tolerance = {});
  /// Of the last state: by every unknown (N): what holds those that are held.
  const Eigen::VectorXd& gradient() const { return gradient_; }

 private:
  double assemble(const Eigen::VectorXd& x, double left_out);
  bool factor(double raised_by);
  double net_force_N() const;

  const Sheet* sheet_;
  std::vector<int> free_;                        ///< unknowns
  std::vector<int> slots_;                       ///< see Sheet::evaluate
  Eigen::SparseMatrix<double> matrix_, raised_;  ///< lower triangle over the free ones
  Eigen::VectorXd gradient_;
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace tenter::twin
