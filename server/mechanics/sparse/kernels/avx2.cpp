// SPDX-License-Identifier: GPL-3.0-or-later
// Panel kernels for AVX2 with FMA.
#include <immintrin.h>

#include "server/mechanics/sparse/kernels/panel_kernels.h"

// Only what follows is compiled for it: the build stays plain x86-64.
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
namespace tenter::mechanics {

namespace {

constexpr int kLanes = 4;        // doubles of a vector
constexpr int kTileBlocks = 1;   // a tile of kTileBlocks * kBlock rows and
constexpr int kTileColumns = 4;  // kTileColumns columns stays in registers

using Vec = __m256d;
inline Vec zero() {
  return _mm256_setzero_pd();
}
inline Vec spread(double value) {
  return _mm256_set1_pd(value);
}
inline Vec load(const double* p) {
  return _mm256_loadu_pd(p);
}
inline void store(double* p, Vec v) {
  _mm256_storeu_pd(p, v);
}
inline Vec subtract(Vec a, Vec b) {
  return _mm256_sub_pd(a, b);
}
inline Vec multiply(Vec a, Vec b) {
  return _mm256_mul_pd(a, b);
}
inline Vec multiply_add(Vec a, Vec b, Vec c) {
  return _mm256_fmadd_pd(a, b, c);
}
inline Vec multiply_subtract(Vec a, Vec b, Vec c) {
  return _mm256_fnmadd_pd(a, b, c);
}
inline double sum(Vec v) {
  const __m128d half = _mm_add_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
  return _mm_cvtsd_f64(_mm_add_sd(half, _mm_unpackhi_pd(half, half)));
}
/// p[i] -= v[i] in the lanes of the mask; touches no other memory.
inline void subtract_lanes(double* p, Vec v, unsigned lanes) {
  const __m256i bit = _mm256_setr_epi64x(1, 2, 4, 8);
  const __m256i chosen = _mm256_and_si256(_mm256_set1_epi64x(lanes), bit);
  const __m256i mask = _mm256_cmpeq_epi64(chosen, bit);
  _mm256_maskstore_pd(p, mask, _mm256_sub_pd(_mm256_maskload_pd(p, mask), v));
}

#include "server/mechanics/sparse/kernels/body.inc"

}  // namespace

const PanelKernels kAvx2Kernels = {"avx2",   factor,        update,        forward,
                                   backward, forward_block, backward_block};

}  // namespace tenter::mechanics

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
