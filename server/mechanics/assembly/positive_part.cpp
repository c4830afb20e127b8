// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/positive_part.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

double without_negative(double value, double share) {
  return value < 0.0 ? (1.0 - share) * value : value;
}

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
void raise_eigenvalues(Square<2>& a, double share) {
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

/// Where M_ij, i <= j, of D dimensions is among the entries of C.
constexpr int stress_row(int i, int j, int dimensions) {
  return i == j ? i : (dimensions == 2 ? 2 : 6 - i - j);
}

template <int D>
void take_positive_part_of_gradient_elements(int count, double share, double* psi_z,
                                             double* psi_zz) {
  constexpr int kEntries = c_entries(D);
  for (int e = 0; e < count; ++e) {
    Square<D> stress;
    for (int i = 0; i < D; ++i) {
      for (int j = i; j < D; ++j)
        stress(i, j) = stress(j, i) =
            (i == j ? 2.0 : 1.0) * psi_z[stress_row(i, j, D) * kChunk + e];
    }
    raise_eigenvalues(stress, share);
    for (int i = 0; i < D; ++i) {
      for (int j = i; j < D; ++j)
        psi_z[stress_row(i, j, D) * kChunk + e] = (i == j ? 0.5 : 1.0) * stress(i, j);
    }
    Square<kEntries> tangent;
    int row = 0;
    for (int k = 0; k < kEntries; ++k)
      for (int l = k; l < kEntries; ++l) tangent(k, l) = tangent(l, k) = psi_zz[row++ * kChunk + e];
    raise_eigenvalues(tangent, share);
    row = 0;
    for (int k = 0; k < kEntries; ++k)
      for (int l = k; l < kEntries; ++l) psi_zz[row++ * kChunk + e] = tangent(k, l);
  }
}

}  // namespace

void take_positive_part(const HingeElements&, int count, double share, double* psi_z,
                        double* psi_zz) {
  for (int e = 0; e < count; ++e) {
    psi_z[e] *= 1.0 - share;
    psi_zz[e] = without_negative(psi_zz[e], share);
  }
}

void take_positive_part(const EdgeElements&, int count, double share, double* psi_z,
                        double* psi_zz) {
  for (int e = 0; e < count; ++e) {
    psi_z[e] = without_negative(psi_z[e], share);
    psi_zz[e] = without_negative(psi_zz[e], share);
  }
}

void take_positive_part(const TriangleElements&, int count, double share, double* psi_z,
                        double* psi_zz) {
  take_positive_part_of_gradient_elements<2>(count, share, psi_z, psi_zz);
}
void take_positive_part(const TetrahedronElements&, int count, double share, double* psi_z,
                        double* psi_zz) {
  take_positive_part_of_gradient_elements<3>(count, share, psi_z, psi_zz);
}
void take_positive_part(const HexahedronPoints&, int count, double share, double* psi_z,
                        double* psi_zz) {
  take_positive_part_of_gradient_elements<3>(count, share, psi_z, psi_zz);
}

}  // namespace tenter::mechanics
