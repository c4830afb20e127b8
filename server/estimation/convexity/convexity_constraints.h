// SPDX-License-Identifier: GPL-3.0-or-later
// What makes an additive energy convex (thesis 4.2.3, 4.11): eigenvalues of Hessians at samples of
// strain,
//
//   C_ijk = lambda_j(H(Psi_i(p, eps_k))) >= 0
//
//   addends of one strain   d2Psi_i/deps2 of the addend alone: a row that is linear in p
//   addends of two strains  the 2 x 2 Hessian of the full energy in the addend's two strains,
//                           of all terms that act at the same place: lambda_min >= 0 of a
//                           matrix that is linear in p, a convex cone
//
// and the parameters' own bounds. The full energy is taken at the right Cauchy-Green tensor nearest
// to rest (in C) that has the two strains. Laws that are linear in their parameters count (linear,
// bilinear, constant_stress, the splines and the Gaussians); ogden and exponential_fibre count in
// the full energy at the values that they had in make(). Laws with a memory are left out, as are
// addends of two strains on solids.
//
//   auto convex = ConvexityConstraints::make(model);
//   if (convex->worst(parameters).smallest < 0) ... at worst.strain of model.terms[worst.term]
//
// Immutable; any thread; worst() costs one pass over the samples.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::estimation {

struct ConvexityOptions {
  /// Even samples of a strain; splines are looked at on both sides of their knots as well.
  int samples = 33;
  int samples_of_two = 9;  ///< along each of two strains
  /// Strains that are sampled where neither the model's strain_ranges nor a spline's range say.
  double lo = -0.1;
  double hi = 0.3;
};

class ConvexityConstraints {
 public:
  /// Parameters are flat, in the order of parameters_of(model) with the corrections at the end.
  static Expected<ConvexityConstraints> make(const model::Model& model,
                                             const ConvexityOptions& options = {});

  struct Worst {
    double smallest = std::numeric_limits<double>::infinity();  ///< eigenvalue, unit of a stiffness
    double relative = std::numeric_limits<double>::infinity();  ///< over the largest of its term
    int term = -1;                                              ///< of the model
    std::array<double, 2> strain = {0.0, 0.0};
  };
  /// The sample with the smallest eigenvalue relative to the largest of the same term.
  Worst worst(const Eigen::VectorXd& parameters) const;

  /// How large parameters are: each the largest of its term, by magnitude.
  Eigen::VectorXd sizes(const Eigen::VectorXd& parameters) const;

  /// Rows r and numbers b with r p >= b that `parameters` break by more than `slack` times what
  /// parameters of these `sizes` would give: rows of addends of one strain and bounds, and for each
  /// matrix with a negative eigenvalue the cut v'H(p)v >= 0 along its eigenvector. Fixed parameters
  /// are moved to b. Appends.
  void add_broken(const Eigen::VectorXd& parameters, const Eigen::VectorXd& sizes, double slack,
                  std::vector<Eigen::VectorXd>& rows, std::vector<double>& least) const;

  /// The same conditions for solvers of smooth constraints, all >= 0: rows, then trace and
  /// determinant of each matrix; `by_p` (conditions x parameters) where not null.
  void smooth_values(const Eigen::VectorXd& parameters, Eigen::VectorXd& values,
                     Eigen::MatrixXd* by_p) const;

  int parameter_count() const { return static_cast<int>(is_fixed_.size()); }
  const std::vector<bool>& is_fixed() const { return is_fixed_; }
  int row_count() const { return static_cast<int>(rows_.size()); }
  int matrix_count() const { return static_cast<int>(matrices_.size()); }

 private:
  struct Row {
    int term = -1;  ///< -1: a bound
    double strain = 0.0;
    Eigen::VectorXd by_p;
    double least = 0.0;
  };
  struct Matrix {
    int term = -1;
    std::array<double, 2> strain = {0.0, 0.0};
    Eigen::Matrix3Xd by_p;                               ///< H_11, H_12, H_22 of each parameter
    Eigen::Vector3d constant = Eigen::Vector3d::Zero();  ///< of laws that are not linear
  };
  struct Builder;

  std::vector<bool> is_fixed_;
  std::vector<int> term_of_;  ///< of each parameter; -1: of a correction
  std::vector<Row> rows_;
  std::vector<Matrix> matrices_;
  int term_count_ = 0;
};

}  // namespace tenter::estimation
