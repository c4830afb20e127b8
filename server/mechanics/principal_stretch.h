// SPDX-License-Identifier: GPL-3.0-or-later
// Principal stretches minus one with their derivatives, of a membrane (Dim 2) or a solid (Dim 3).
//
// With C = sum_i c_i n_i n_i', z the distinct entries of C and m_ij the derivative of n_i'.C.n_j by
// z at fixed n:
//
//   lambda_i = sqrt(c_i)     dc_i = m_ii     d2c_i = 2 sum_(j != i) m_ij m_ij' / (c_i - c_j)
//
// The second derivative of a single stretch has no limit where two are equal, as at rest, but that
// of a term whose law treats the stretches alike has: with g_i = dPsi/dc_i the pair (i, j) gives
//
//   2 (g_i - g_j)/(c_i - c_j) m_ij m_ij'  ->  2 (dg_i/dc_i - dg_i/dc_j) m_ij m_ij'
//
// So pairs closer than kNearPair are left out of the strains' second derivatives and listed, and
// add_near_pairs puts them into the Hessian of the term:
//
//   H = sum_ij tangent_ij by_z_i by_z_j' + sum_i stress_i by_zz_i;
//   add_near_pairs(value.near, value.near_count, value.value, law.stress, law.tangent, H);
//
// The quotient loses eps/gap, the limit (symmetrised) gap^2: both below 1e-10 at kNearPair.
// Stateless; any thread; no allocation; about half a microsecond in three dimensions.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

/// Stretches below this keep their derivatives at this: collapsed elements give finite answers.
constexpr double kCollapsedStretch = 1e-8;
/// Two c_i are near where their distance is below this share of the larger one.
constexpr double kNearPair = 1e-5;

/// Two stretches too close for a quotient of differences.
template <int N>
struct NearPair {
  int i = 0;
  int j = 0;
  Eigen::Matrix<double, N, 1> m;
};

/// (00, 11, 01) of a membrane; (00, 11, 22, 12, 02, 01) of a solid.
template <int Dim>
Eigen::Matrix<double, Dim, Dim> symmetric_from(
    const Eigen::Matrix<double, Dim*(Dim + 1) / 2, 1>& z) {
  Eigen::Matrix<double, Dim, Dim> c;
  if constexpr (Dim == 2)
    c << z[0], z[2], z[2], z[1];
  else
    c << z[0], z[5], z[4], z[5], z[1], z[3], z[4], z[3], z[2];
  return c;
}

/// Derivative of a'.C.b by z.
template <int Dim>
Eigen::Matrix<double, Dim*(Dim + 1) / 2, 1> pair_by_z(const Eigen::Matrix<double, Dim, 1>& a,
                                                      const Eigen::Matrix<double, Dim, 1>& b) {
  if constexpr (Dim == 2) {
    return {a[0] * b[0], a[1] * b[1], a[0] * b[1] + a[1] * b[0]};
  } else {
    Eigen::Matrix<double, 6, 1> m;
    m << a[0] * b[0], a[1] * b[1], a[2] * b[2], a[1] * b[2] + a[2] * b[1],
        a[0] * b[2] + a[2] * b[0], a[0] * b[1] + a[1] * b[0];
    return m;
  }
}

/// Strains in falling order, their derivatives, and the near pairs; returns how many there are.
template <int Dim, int N = Dim*(Dim + 1) / 2>
int principal_stretches(const Eigen::Matrix<double, N, 1>& z, double* value,
                        Eigen::Matrix<double, N, 1>* by_z, Eigen::Matrix<double, N, N>* by_zz,
                        NearPair<N>* near) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Dim, Dim>> eigen(
      symmetric_from<Dim>(z));
  const auto n = [&eigen](int i) -> Eigen::Matrix<double, Dim, 1> {
    return eigen.eigenvectors().col(Dim - 1 - i);
  };
  double c[Dim];
  for (int i = 0; i < Dim; ++i) c[i] = std::max(eigen.eigenvalues()[Dim - 1 - i], 0.0);
  for (int i = 0; i < Dim; ++i) {
    const double lambda = std::max(std::sqrt(c[i]), kCollapsedStretch);
    value[i] = std::sqrt(c[i]) - 1.0;
    const Eigen::Matrix<double, N, 1> c_by_z = pair_by_z<Dim>(n(i), n(i));
    by_z[i] = c_by_z / (2.0 * lambda);
    by_zz[i] = -(c_by_z * c_by_z.transpose()) / (4.0 * lambda * lambda * lambda);
  }
  int near_count = 0;
  for (int i = 0; i < Dim; ++i) {
    for (int j = i + 1; j < Dim; ++j) {
      const Eigen::Matrix<double, N, 1> m = pair_by_z<Dim>(n(i), n(j));
      const double gap = c[i] - c[j];
      if (gap <= kNearPair * c[i]) {
        near[near_count++] = {i, j, m};
        continue;
      }
      const Eigen::Matrix<double, N, N> spin = m * m.transpose() / gap;
      by_zz[i] += spin / std::max(std::sqrt(c[i]), kCollapsedStretch);
      by_zz[j] -= spin / std::max(std::sqrt(c[j]), kCollapsedStretch);
    }
  }
  return near_count;
}

/// Adds what the near pairs give to the Hessian by z of a term with these stresses and tangents.
template <int N, int Row>
void add_near_pairs(const NearPair<N>* near, int near_count, const double* strain,
                    const double* stress, const double (*tangent)[Row],
                    Eigen::Matrix<double, N, N>& hessian) {
  for (int p = 0; p < near_count; ++p) {
    const int i = near[p].i;
    const int j = near[p].j;
    const double li = std::max(1.0 + strain[i], kCollapsedStretch);
    const double lj = std::max(1.0 + strain[j], kCollapsedStretch);
    const double own = 0.5 * (tangent[i][i] / (li * li) - stress[i] / (li * li * li) +
                              tangent[j][j] / (lj * lj) - stress[j] / (lj * lj * lj));
    const double quotient = 0.25 * (own - tangent[i][j] / (li * lj));
    hessian += 2.0 * quotient * near[p].m * near[p].m.transpose();
  }
}

}  // namespace tenter::mechanics
