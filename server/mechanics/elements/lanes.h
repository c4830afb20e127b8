// SPDX-License-Identifier: GPL-3.0-or-later
// Eight elements at once: the number type of the element kernels.
//
// `Lanes` holds one number of each of eight elements; arithmetic on it is element-wise. A function
// that works on lanes is marked TENTER_KERNEL: it is compiled for AVX-512, AVX2 and the baseline,
// and the processor's own version is chosen when the program is loaded. On one machine the same
// input gives the same bytes, whatever the thread.
//
// For the sources of kernels only: a header that others read must not pass Lanes around.
#pragma once

#include <cmath>

#include "server/mechanics/elements/chunk.h"

#if defined(__clang__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TENTER_KERNEL  // one version: the sanitizers do not follow the choice at load time
#else
#define TENTER_KERNEL __attribute__((target_clones("avx512f", "avx2", "default")))
#endif
#define TENTER_INLINE inline __attribute__((always_inline))

namespace tenter::mechanics {

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));

/// The same eight numbers anywhere in an array of double.
typedef double UnalignedLanes
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(sizeof(double)), may_alias));
TENTER_INLINE Lanes load(const double* from) {
  return *reinterpret_cast<const UnalignedLanes*>(from);
}
TENTER_INLINE void store(const Lanes& value, double* to) {
  *reinterpret_cast<UnalignedLanes*>(to) = value;
}

TENTER_INLINE Lanes root(const Lanes& x) {
  Lanes result;
  for (int l = 0; l < kLanes; ++l) result[l] = std::sqrt(x[l]);
  return result;
}

/// A vector in space for each of eight elements.
struct Lanes3 {
  Lanes x{}, y{}, z{};
};

TENTER_INLINE Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
TENTER_INLINE Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
TENTER_INLINE Lanes3 operator*(const Lanes& s, const Lanes3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
TENTER_INLINE Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
TENTER_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A 3 x 3 block for each of eight elements, column-major as NodeMatrix stores it.
struct Lanes33 {
  Lanes v[9];
};

/// block += a b'
TENTER_INLINE void add_outer(Lanes33& block, const Lanes3& a, const Lanes3& b) {
  block.v[0] += a.x * b.x;
  block.v[1] += a.y * b.x;
  block.v[2] += a.z * b.x;
  block.v[3] += a.x * b.y;
  block.v[4] += a.y * b.y;
  block.v[5] += a.z * b.y;
  block.v[6] += a.x * b.z;
  block.v[7] += a.y * b.z;
  block.v[8] += a.z * b.z;
}

/// The positions of one corner of eight elements; nodes[l] is the corner of element l.
TENTER_INLINE Lanes3 gather(const double* positions, const int* nodes) {
  Lanes3 result;
  for (int l = 0; l < kLanes; ++l) {
    const double* p = positions + 3 * nodes[l];
    result.x[l] = p[0];
    result.y[l] = p[1];
    result.z[l] = p[2];
  }
  return result;
}

}  // namespace tenter::mechanics
