// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/positive_part.h"

#include "server/mechanics/raise_eigenvalues.h"

namespace tenter::mechanics {
namespace {

double without_negative(double value, double share) {
  return value < 0.0 ? (1.0 - share) * value : value;
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
