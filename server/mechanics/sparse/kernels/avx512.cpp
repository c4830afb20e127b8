// SPDX-License-Identifier: GPL-3.0-or-later
// Panel kernels for AVX-512.
#include <immintrin.h>

#include "server/mechanics/sparse/kernels/panel_kernels.h"

// Only what follows is compiled for it: the build stays plain x86-64.
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,fma")
#endif
namespace tenter::mechanics {

namespace {

constexpr int kLanes = 8;        // doubles of a vector
constexpr int kTileBlocks = 3;   // a tile of kTileBlocks * kBlock rows and
constexpr int kTileColumns = 8;  // kTileColumns columns stays in registers

using Vec = __m512d;
inline Vec zero() {
  return _mm512_setzero_pd();
}
inline Vec spread(double value) {
  return _mm512_set1_pd(value);
}
inline Vec load(const double* p) {
  return _mm512_loadu_pd(p);
}
inline void store(double* p, Vec v) {
  _mm512_storeu_pd(p, v);
}
inline Vec subtract(Vec a, Vec b) {
  return _mm512_sub_pd(a, b);
}
inline Vec multiply(Vec a, Vec b) {
  return _mm512_mul_pd(a, b);
}
inline Vec multiply_add(Vec a, Vec b, Vec c) {
  return _mm512_fmadd_pd(a, b, c);
}
inline Vec multiply_subtract(Vec a, Vec b, Vec c) {
  return _mm512_fnmadd_pd(a, b, c);
}
inline double sum(Vec v) {
  alignas(64) double a[8];
  _mm512_store_pd(a, v);
  return ((a[0] + a[4]) + (a[1] + a[5])) + ((a[2] + a[6]) + (a[3] + a[7]));
}
/// p[i] -= v[i] in the lanes of the mask; touches no other memory.
inline void subtract_lanes(double* p, Vec v, unsigned lanes) {
  const __mmask8 mask = static_cast<__mmask8>(lanes);
  _mm512_mask_storeu_pd(p, mask, _mm512_sub_pd(_mm512_maskz_loadu_pd(mask, p), v));
}

#include "server/mechanics/sparse/kernels/body.inc"

}  // namespace

const PanelKernels kAvx512Kernels = {"avx512", factor,        update,        forward,
                                     backward, forward_block, backward_block};

}  // namespace tenter::mechanics

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
