// SPDX-License-Identifier: GPL-3.0-or-later
// Panel kernels for any x86-64.
#include <immintrin.h>

#include "server/mechanics/sparse/kernels/panel_kernels.h"

namespace tenter::mechanics {

namespace {

constexpr int kLanes = 2;        // doubles of a vector
constexpr int kTileBlocks = 1;   // a tile of kTileBlocks * kBlock rows and
constexpr int kTileColumns = 2;  // kTileColumns columns stays in registers

using Vec = __m128d;
inline Vec zero() {
  return _mm_setzero_pd();
}
inline Vec spread(double value) {
  return _mm_set1_pd(value);
}
inline Vec load(const double* p) {
  return _mm_loadu_pd(p);
}
inline void store(double* p, Vec v) {
  _mm_storeu_pd(p, v);
}
inline Vec subtract(Vec a, Vec b) {
  return _mm_sub_pd(a, b);
}
inline Vec multiply(Vec a, Vec b) {
  return _mm_mul_pd(a, b);
}
inline Vec multiply_add(Vec a, Vec b, Vec c) {
  return _mm_add_pd(_mm_mul_pd(a, b), c);
}
inline Vec multiply_subtract(Vec a, Vec b, Vec c) {
  return _mm_sub_pd(c, _mm_mul_pd(a, b));
}
inline double sum(Vec v) {
  return _mm_cvtsd_f64(_mm_add_sd(v, _mm_unpackhi_pd(v, v)));
}
/// p[i] -= v[i] in the lanes of the mask; touches no other memory.
inline void subtract_lanes(double* p, Vec v, unsigned lanes) {
  if ((lanes & 1) != 0) p[0] -= _mm_cvtsd_f64(v);
  if ((lanes & 2) != 0) p[1] -= _mm_cvtsd_f64(_mm_unpackhi_pd(v, v));
}

#include "server/mechanics/sparse/kernels/body.inc"

}  // namespace

const PanelKernels kPortableKernels = {"portable", factor,        update,        forward,
                                       backward,   forward_block, backward_block};

}  // namespace tenter::mechanics
