// SPDX-License-Identifier: GPL-3.0-or-later
// From eight elements side by side to their blocks in a NodeMatrix. For the sources of kernels
// only, as lanes.h.
#pragma once

#include "server/mechanics/elements/lanes.h"
#include "server/mechanics/elements/node_matrix.h"

namespace tenter::mechanics {

/// v[i][j] becomes v[j][i].
TENTER_INLINE void transpose(Lanes (&v)[kLanes]) {
  static_assert(kLanes == 8);
  Lanes a[8], b[8];
  for (int i = 0; i < 8; i += 2) {
    a[i] = __builtin_shufflevector(v[i], v[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    a[i + 1] = __builtin_shufflevector(v[i], v[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int i = 0; i < 8; i += 4) {
    for (int k = 0; k < 2; ++k) {
      b[i + k] = __builtin_shufflevector(a[i + k], a[i + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      b[i + k + 2] = __builtin_shufflevector(a[i + k], a[i + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int i = 0; i < 4; ++i) {
    v[i] = __builtin_shufflevector(b[i], b[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    v[i + 4] = __builtin_shufflevector(b[i], b[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

/// Adds blocks[pair] of the first `lanes` elements where slots[element * Pairs + pair] says.
template <int Pairs>
TENTER_INLINE void scatter(const Lanes33 (&blocks)[Pairs], int lanes, const int* slots,
                           NodeMatrix& matrix) {
  for (int pair = 0; pair < Pairs; ++pair) {
    // a block has nine numbers: eight of them are one vector, the ninth is on its diagonal
    Lanes head[kLanes];
    for (int i = 0; i < kLanes; ++i) head[i] = blocks[pair].v[i];
    transpose(head);
    const Lanes& last = blocks[pair].v[8];
    for (int l = 0; l < lanes; ++l) {
      const int slot = slots[l * Pairs + pair];
      double* target = matrix.block(slot >= 0 ? slot : -1 - slot);
      const Lanes block =
          slot >= 0 ? head[l] : __builtin_shufflevector(head[l], head[l], 0, 3, 6, 1, 4, 7, 2, 5);
      store(load(target) + block, target);
      target[8] += last[l];
    }
  }
}

}  // namespace tenter::mechanics
