// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/factor.h"
#include "server/mechanics/sparse/kernels/panel_kernels.h"

namespace tenter::mechanics {

// Measured by tests/bench/equilibrium: with AVX2 or better ours takes 0.25 to 0.65 of CHOLMOD's
// time from 25 x 25 to 100 x 100 nodes; without, it wins on the smallest only, where little is
// lost.
std::unique_ptr<SparseFactor> make_factor() {
  if (runnable_panel_kernels().front() == &kPortableKernels) return make_cholmod_factor();
  return make_supernodal_factor();
}

}  // namespace tenter::mechanics
