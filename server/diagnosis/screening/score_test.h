// SPDX-License-Identifier: GPL-3.0-or-later
// The score test: what would columns that a fit does not have take from its residuals?
//
// With whitened residuals r, own columns J and a candidate's columns Z,
//
//   P = I - J (J'J)^-1 J'      T = r'P Z (Z'P Z)^-1 Z'P r       the expected fall of chi2
//   u = T / 95th percentile of T over null twins                (design, steps 4 and 5)
//
// An amplitude that must not be negative is tested one-sided where there is one of them. Of several
// T is that of all their space, and `within` is what bounds leave of it: the fall of chi2 that a
// refit can reach.
//
//   Ground ground{range_basis(own), twins, residuals};          // see settle()
//   if (auto score = score_test(ground, z, least)) ... score->gain, score->u
//
// Numbers in, numbers out: of curves and sheets alike. Rows may be any orthonormal coordinates of
// the space that J, Z and r span: then null twins are drawn there. One thread; cost is a QR of Z
// and a product of twins by Z.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace tenter::diagnosis {

/// Orthonormal basis of the columns of J that carry anything.
Eigen::MatrixXd range_basis(const Eigen::MatrixXd& j);

/// The value below which a share of them lies; not empty.
double percentile(std::vector<double> values, double share);

/// What all candidates of one screen share.
struct Ground {
  Eigen::MatrixXd own;    ///< orthonormal basis of the model's own columns
  Eigen::MatrixXd twins;  ///< null twins, without what the model absorbs
  Eigen::VectorXd left;   ///< residuals, likewise
};
/// Takes what the own columns absorb from twins and residuals.
void settle(Ground& ground);

/// The space that a candidate adds to the model's own, and what it makes of the residuals.
struct Projected {
  Eigen::MatrixXd basis;       ///< rows x df, orthonormal, orthogonal to J
  Eigen::VectorXd amplitudes;  ///< least-squares values of the candidate's columns
  bool positive =
      false;  ///< one column whose amplitude must not be negative; the basis points to more of it
};
/// `z` is worked on. No columns where all hide in the model's own. `least`: the smallest amplitude
/// of each column that may be; minus infinity: any.
Projected project(Eigen::MatrixXd z, const std::vector<double>& least, const Eigen::MatrixXd& own,
                  const Eigen::VectorXd& residuals);

struct Tested {
  double gain = 0.0;    ///< T
  double within = 0.0;  ///< of it with no amplitude below its least
  int df = 0;
  double u = 0.0;
  Eigen::VectorXd direction;   ///< what it would take from the residuals
  Eigen::VectorXd amplitudes;  ///< of the columns, from where they are off; none below its least
  Eigen::MatrixXd space;       ///< orthonormal basis of what the columns add to the own ones
};
/// None where the columns hide in the model's own. `largest`, where given, collects each twin's
/// largest u.
std::optional<Tested> score_test(const Ground& ground, const Eigen::MatrixXd& z,
                                 const std::vector<double>& least,
                                 std::vector<double>* largest = nullptr);

/// Largest canonical correlation of two spaces, each given by an orthonormal basis: from 0 to 1.
double canonical_correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace tenter::diagnosis
