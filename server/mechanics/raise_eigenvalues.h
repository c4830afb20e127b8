// SPDX-License-Identifier: GPL-3.0-or-later
// Small symmetric matrices without a share of their negative eigenvalues: lambda < 0 becomes
// (1 - share) lambda. Share 1 gives the nearest positive semidefinite matrix in the Frobenius norm.
//
// Pure; no allocation. A matrix that is not finite stays as it is.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace tenter::mechanics {

template <int N>
using Square = Eigen::Matrix<double, N, N>;

/// True where the rows' diagonals outweigh the rest: positive semidefinite without further work.
template <int N>
bool is_dominated_by_diagonal(const Square<N>& a) {
  for (int i = 0; i < N; ++i)
    if (2.0 * a(i, i) < a.row(i).cwiseAbs().sum()) return false;
  return true;
}

/// In closed form: this is on the path of every iteration far from a minimum.
inline void raise_eigenvalues(Square<2>& a, double share) {
  const double middle = 0.5 * (a(0, 0) + a(1, 1));
  const double half = 0.5 * (a(0, 0) - a(1, 1));
  const double radius = std::sqrt(half * half + a(0, 1) * a(0, 1));
  if (!(middle < radius)) return;  // the lower eigenvalue is middle - radius
  if (middle + radius <= 0.0) {
    a *= 1.0 - share;
    return;
  }
  // a - share lower P, where P = (upper - a)/(upper - lower) projects on the lower one's direction
  const double upper = middle + radius;
  const double factor = -share * (middle - radius) / (2.0 * radius);
  a *= 1.0 - factor;
  a.diagonal().array() += factor * upper;
}

template <int N>
void raise_eigenvalues(Square<N>& a, double share) {
  if (is_dominated_by_diagonal<N>(a) || !a.allFinite()) return;
  Eigen::SelfAdjointEigenSolver<Square<N>> eigen(a);
  if (eigen.eigenvalues()[0] >= 0.0) return;
  const Eigen::Matrix<double, N, 1> raise = -share * eigen.eigenvalues().cwiseMin(0.0);
  a += eigen.eigenvectors() * raise.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace tenter::mechanics
