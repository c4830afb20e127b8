// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/elements/gradient_elements.h"

#include <algorithm>
#include <numeric>

#include "server/mechanics/elements/scatter.h"

namespace tenter::mechanics {
namespace {

/// Entry of z for the pair (i, j) of columns of F.
template <int D>
constexpr int entry(int i, int j) {
  if (i == j) return i;
  if constexpr (D == 2) return 2;
  return 6 - i - j;  // (1,2) 3, (0,2) 4, (0,1) 5
}

/// Place of (k, l) in the upper triangle of a K x K matrix, row by row.
template <int K>
constexpr int upper(int k, int l) {
  const int i = std::min(k, l);
  const int j = std::max(k, l);
  return i * K - i * (i - 1) / 2 + (j - i);
}

template <int N, int D>
TENTER_INLINE Lanes shape_of(const GradientElements<N, D>& elements, int corner, int axis, int e) {
  return load(elements.shape.data() + (corner * D + axis) * elements.padded() + e);
}

/// Columns of F.
template <int N, int D>
TENTER_INLINE void deformation_gradient(const GradientElements<N, D>& elements,
                                        const double* positions, int e, Lanes3* f) {
  for (int i = 0; i < D; ++i) f[i] = Lanes3{};
  for (int a = 0; a < N; ++a) {
    const Lanes3 x = gather(positions, elements.gathered.data() + a * elements.padded() + e);
    for (int i = 0; i < D; ++i) f[i] = f[i] + shape_of(elements, a, i, e) * x;
  }
}

template <int N, int D>
TENTER_INLINE void cauchy_green_kernel(const GradientElements<N, D>& elements,
                                       const double* positions, int first, int count, double* z) {
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 f[D];
    deformation_gradient(elements, positions, first + e, f);
    for (int i = 0; i < D; ++i) {
      for (int j = i; j < D; ++j) {
        store(dot(f[i], f[j]), z + entry<D>(i, j) * kChunk + e);
      }
    }
  }
}

template <int N, int D>
TENTER_INLINE void change_kernel(const GradientElements<N, D>& elements, const double* positions,
                                 const double* dx, int first, int count, double* dz) {
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 f[D], df[D];
    deformation_gradient(elements, positions, first + e, f);
    deformation_gradient(elements, dx, first + e, df);
    for (int i = 0; i < D; ++i)
      for (int j = i; j < D; ++j)
        store(dot(f[i], df[j]) + dot(df[i], f[j]), dz + entry<D>(i, j) * kChunk + e);
  }
}

template <int N>
TENTER_INLINE void volume_kernel(const GradientElements<N, 3>& elements, const double* positions,
                                 int first, int count, double* j) {
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 f[3];
    deformation_gradient(elements, positions, first + e, f);
    store(dot(f[0], cross(f[1], f[2])), j + e);
  }
}

/// M of the header.
template <int D>
TENTER_INLINE void stress_matrix(const double* psi_z, int e, Lanes (&m)[D][D]) {
  for (int i = 0; i < D; ++i) {
    for (int j = 0; j < D; ++j) {
      const Lanes psi = load(psi_z + entry<D>(i, j) * kChunk + e);
      m[i][j] = i == j ? psi + psi : psi;
    }
  }
}

template <int N, int D>
TENTER_INLINE void gradient_kernel(const GradientElements<N, D>& elements, const double* positions,
                                   int first, int count, const double* psi_z, double* gradient) {
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 f[D];
    deformation_gradient(elements, positions, first + e, f);
    Lanes m[D][D];
    stress_matrix<D>(psi_z, e, m);
    Lanes3 p[D];  // dE/dF_i
    for (int i = 0; i < D; ++i) {
      p[i] = m[i][0] * f[0];
      for (int j = 1; j < D; ++j) p[i] = p[i] + m[i][j] * f[j];
    }
    const int lanes = std::min(kLanes, count - e);
    for (int a = 0; a < N; ++a) {
      Lanes3 force = shape_of(elements, a, 0, first + e) * p[0];
      for (int i = 1; i < D; ++i) force = force + shape_of(elements, a, i, first + e) * p[i];
      const int* node = elements.gathered.data() + a * elements.padded() + first + e;
      for (int l = 0; l < lanes; ++l) {
        double* g = gradient + 3 * node[l];
        g[0] += force.x[l];
        g[1] += force.y[l];
        g[2] += force.z[l];
      }
    }
  }
}

/// B_ak of the header for one corner.
template <int N, int D>
TENTER_INLINE void entry_derivatives(const GradientElements<N, D>& elements, const Lanes3* f, int a,
                                     int e, Lanes3* b) {
  for (int i = 0; i < D; ++i) {
    const Lanes shape_i = shape_of(elements, a, i, e);
    b[i] = (shape_i + shape_i) * f[i];
    for (int j = i + 1; j < D; ++j)
      b[entry<D>(i, j)] = shape_i * f[j] + shape_of(elements, a, j, e) * f[i];
  }
}

/// Blocks of the corners 1..N-1; those of corner 0 follow, since shape gradients sum to zero.
template <int N, int D>
TENTER_INLINE void stiffness_kernel(const GradientElements<N, D>& elements, const double* positions,
                                    int first, int count, const double* psi_z, const double* psi_zz,
                                    NodeMatrix& matrix) {
  constexpr int kZ = GradientElements<N, D>::kEntries;
  constexpr int kPairs = N * (N + 1) / 2;
  for (int e = 0; e < count; e += kLanes) {
    Lanes3 f[D];
    deformation_gradient(elements, positions, first + e, f);
    Lanes m[D][D];
    stress_matrix<D>(psi_z, e, m);
    Lanes h[c_entries(kZ)];
    for (int k = 0; k < c_entries(kZ); ++k) h[k] = load(psi_zz + k * kChunk + e);

    Lanes33 blocks[kPairs] = {};
    Lanes3 b[N][kZ];
    for (int a = 1; a < N; ++a) entry_derivatives(elements, f, a, first + e, b[a]);
    for (int c = 1; c < N; ++c) {
      Lanes3 hb[kZ];
      for (int k = 0; k < kZ; ++k) {
        hb[k] = h[upper<kZ>(k, 0)] * b[c][0];
        for (int l = 1; l < kZ; ++l) hb[k] = hb[k] + h[upper<kZ>(k, l)] * b[c][l];
      }
      Lanes mb[D];
      for (int i = 0; i < D; ++i) {
        mb[i] = m[i][0] * shape_of(elements, c, 0, first + e);
        for (int j = 1; j < D; ++j) mb[i] += m[i][j] * shape_of(elements, c, j, first + e);
      }
      for (int a = c; a < N; ++a) {
        Lanes33& block = blocks[a * (a + 1) / 2 + c];
        for (int k = 0; k < kZ; ++k) add_outer(block, b[a][k], hb[k]);
        Lanes s = shape_of(elements, a, 0, first + e) * mb[0];
        for (int i = 1; i < D; ++i) s += shape_of(elements, a, i, first + e) * mb[i];
        for (int r = 0; r < 3; ++r) block.v[4 * r] += s;
      }
    }
    for (int a = 1; a < N; ++a) {
      Lanes33& column = blocks[a * (a + 1) / 2];  // (a, 0)
      for (int c = 1; c < N; ++c) {
        const Lanes33& k = blocks[a >= c ? a * (a + 1) / 2 + c : c * (c + 1) / 2 + a];
        for (int col = 0; col < 3; ++col)
          for (int r = 0; r < 3; ++r)
            column.v[3 * col + r] -= a >= c ? k.v[3 * col + r] : k.v[3 * r + col];
      }
      for (int q = 0; q < 9; ++q) blocks[0].v[q] -= column.v[q];
    }

    scatter(blocks, std::min(kLanes, count - e), elements.slots.data() + (first + e) * kPairs,
            matrix);
  }
}

}  // namespace

template <int N, int D>
void GradientElements<N, D>::add(std::array<int, N> corners,
                                 std::array<std::array<double, D>, N> gradients,
                                 double rest_measure) {
  // corners of an element may be taken in any order; increasing, no block needs to be transposed
  std::array<int, N> order;
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return corners[static_cast<std::size_t>(a)] < corners[static_cast<std::size_t>(b)];
  });
  std::array<int, N> sorted;
  std::array<std::array<double, D>, N> sorted_gradients;
  for (std::size_t a = 0; a < N; ++a) {
    sorted[a] = corners[static_cast<std::size_t>(order[a])];
    sorted_gradients[a] = gradients[static_cast<std::size_t>(order[a])];
  }
  nodes.push_back(sorted);
  gradients_.push_back(sorted_gradients);
  measure.push_back(rest_measure);
}

template <int N, int D>
void GradientElements<N, D>::finish() {
  if (nodes.empty()) return;
  const auto stride = static_cast<std::size_t>(padded());
  shape.assign(N * D * stride, 0.0);
  gathered.assign(N * stride, 0);
  for (std::size_t e = 0; e < stride; ++e) {
    const std::size_t from = std::min(e, nodes.size() - 1);  // the padding repeats the last element
    for (std::size_t a = 0; a < N; ++a) {
      gathered[a * stride + e] = nodes[from][a];
      for (std::size_t i = 0; i < D; ++i) shape[(a * D + i) * stride + e] = gradients_[from][a][i];
    }
  }
  gradients_ = {};
}

template struct GradientElements<2, 1>;
template struct GradientElements<3, 2>;
template struct GradientElements<4, 3>;
template struct GradientElements<8, 3>;

// The chosen version of a kernel is a plain function: one of each for every kind of element.
#define TENTER_ELEMENT_KERNELS(Elements)                                                         \
  TENTER_KERNEL void cauchy_green(const Elements& elements, const double* positions, int first,  \
                                  int count, double* z) {                                        \
    cauchy_green_kernel(elements, positions, first, count, z);                                   \
  }                                                                                              \
  TENTER_KERNEL void cauchy_green_change(const Elements& elements, const double* positions,      \
                                         const double* dx, int first, int count, double* dz) {   \
    change_kernel(elements, positions, dx, first, count, dz);                                    \
  }                                                                                              \
  TENTER_KERNEL void add_gradient(const Elements& elements, const double* positions, int first,  \
                                  int count, const double* psi_z, double* gradient) {            \
    gradient_kernel(elements, positions, first, count, psi_z, gradient);                         \
  }                                                                                              \
  TENTER_KERNEL void add_stiffness(const Elements& elements, const double* positions, int first, \
                                   int count, const double* psi_z, const double* psi_zz,         \
                                   NodeMatrix& matrix) {                                         \
    stiffness_kernel(elements, positions, first, count, psi_z, psi_zz, matrix);                  \
  }

TENTER_ELEMENT_KERNELS(EdgeElements)
TENTER_ELEMENT_KERNELS(TriangleElements)
TENTER_ELEMENT_KERNELS(TetrahedronElements)
TENTER_ELEMENT_KERNELS(HexahedronPoints)
#undef TENTER_ELEMENT_KERNELS

TENTER_KERNEL void volume_ratios(const TetrahedronElements& elements, const double* positions,
                                 int first, int count, double* j) {
  volume_kernel(elements, positions, first, count, j);
}
TENTER_KERNEL void volume_ratios(const HexahedronPoints& elements, const double* positions,
                                 int first, int count, double* j) {
  volume_kernel(elements, positions, first, count, j);
}

}  // namespace tenter::mechanics
