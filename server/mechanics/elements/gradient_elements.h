// SPDX-License-Identifier: GPL-3.0-or-later
// Elements that see positions through the deformation gradient alone: edges (2 nodes, a line),
// triangles (3, a surface), tetrahedra (4, a solid) and the quadrature points of hexahedra (8, a
// solid).
//
//   F_i = sum over corners a  b_ai x_a              thesis (3.2); b: gradients of shape functions
//   z   = entries of C = F'F                        surface: (C_uu, C_vv, C_uv)
//                                                   solid:   (C_00, C_11, C_22, C_12, C_02, C_01)
//                                                   line:    (C_00)
//   E   = sum over elements  m psi(z)               m: length, area or volume at rest
//
// A strain measure is a function of z, so measures and laws know nothing of nodes: they hand back
// dpsi/dz and d2psi/dz2, and this file turns them into forces and stiffness,
//
//   dE/dx_a          = m sum_k psi_k  B_ak                       B_ak = dz_k/dx_a
//   d2E/dx_a dx_b    = m (sum_kl psi_kl B_ak B_bl' + s_ab I)     s_ab = sum_ij b_ai b_bj M_ij
//
// with M_ii = 2 psi_ii, M_ij = psi_ij (z is quadratic in x). Works on chunks of elements; per-chunk
// arrays are [row][kChunk]. Nothing allocates; callable from any thread.
#pragma once

#include <array>
#include <vector>

#include "server/mechanics/elements/chunk.h"
#include "server/mechanics/elements/node_matrix.h"

namespace tenter::mechanics {

/// Number of entries of C in D dimensions, and of the upper triangle over them.
constexpr int c_entries(int dimensions) {
  return dimensions * (dimensions + 1) / 2;
}

template <int N, int D>
struct GradientElements {
  static constexpr int kCorners = N;
  static constexpr int kEntries = c_entries(D);

  std::vector<std::array<int, N>> nodes;  ///< in increasing order within an element
  std::vector<double> measure;            ///< m, m^2 or m^3 at rest
  std::vector<double> shape;              ///< b: [(a D + i) * padded() + element], 1/m
  std::vector<int> gathered;              ///< nodes again: [a * padded() + element]
  std::vector<int> slots;                 ///< see block_slots

  int count() const { return static_cast<int>(nodes.size()); }
  int padded() const { return (count() + kLanes - 1) / kLanes * kLanes; }

  /// `gradients[a][i]` = b_ai of the corners in the order of `corners`.
  void add(std::array<int, N> corners, std::array<std::array<double, D>, N> gradients,
           double rest_measure);
  /// Call once after the last add.
  void finish();

 private:
  std::vector<std::array<std::array<double, D>, N>> gradients_;
};

using EdgeElements = GradientElements<2, 1>;
using TriangleElements = GradientElements<3, 2>;
using TetrahedronElements = GradientElements<4, 3>;
using HexahedronPoints = GradientElements<8, 3>;

/// z of `count` elements from `first` (a multiple of kLanes, count <= kChunk).
void cauchy_green(const EdgeElements&, const double* positions, int first, int count, double* z);
void cauchy_green(const TriangleElements&, const double* positions, int first, int count,
                  double* z);
void cauchy_green(const TetrahedronElements&, const double* positions, int first, int count,
                  double* z);
void cauchy_green(const HexahedronPoints&, const double* positions, int first, int count,
                  double* z);

/// How z changes with displacements `dx` of the nodes, at `positions`; layout as z.
void cauchy_green_change(const EdgeElements&, const double* positions, const double* dx, int first,
                         int count, double* dz);
void cauchy_green_change(const TriangleElements&, const double* positions, const double* dx,
                         int first, int count, double* dz);
void cauchy_green_change(const TetrahedronElements&, const double* positions, const double* dx,
                         int first, int count, double* dz);
void cauchy_green_change(const HexahedronPoints&, const double* positions, const double* dx,
                         int first, int count, double* dz);

/// det F of solids: relative volume, negative where an element is turned inside out, which C does
/// not show. Layout j[e].
void volume_ratios(const TetrahedronElements&, const double* positions, int first, int count,
                   double* j);
void volume_ratios(const HexahedronPoints&, const double* positions, int first, int count,
                   double* j);

/// gradient += dE/dx, from psi_z[k * kChunk + e], already multiplied by the elements' measure.
void add_gradient(const EdgeElements&, const double* positions, int first, int count,
                  const double* psi_z, double* gradient);
void add_gradient(const TriangleElements&, const double* positions, int first, int count,
                  const double* psi_z, double* gradient);
void add_gradient(const TetrahedronElements&, const double* positions, int first, int count,
                  const double* psi_z, double* gradient);
void add_gradient(const HexahedronPoints&, const double* positions, int first, int count,
                  const double* psi_z, double* gradient);

/// matrix += d2E/dx2, from psi_z and psi_zz[(upper triangle, row by row) * kChunk + e], both times
/// the measure.
void add_stiffness(const EdgeElements&, const double* positions, int first, int count,
                   const double* psi_z, const double* psi_zz, NodeMatrix& matrix);
void add_stiffness(const TriangleElements&, const double* positions, int first, int count,
                   const double* psi_z, const double* psi_zz, NodeMatrix& matrix);
void add_stiffness(const TetrahedronElements&, const double* positions, int first, int count,
                   const double* psi_z, const double* psi_zz, NodeMatrix& matrix);
void add_stiffness(const HexahedronPoints&, const double* positions, int first, int count,
                   const double* psi_z, const double* psi_zz, NodeMatrix& matrix);

}  // namespace tenter::mechanics
