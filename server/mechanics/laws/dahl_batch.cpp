// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl friction on many strains: the formulas of dahl.cpp, eight at a time. A strain that crosses
// zero in its step is rare and goes through dahl_step.
#include <algorithm>

#include "server/mechanics/elements/exponential.h"
#include "server/mechanics/laws/dahl.h"

namespace tenter::mechanics {
namespace {

/// Arrays of a multiple of eight strains; energy is added to.
struct Eights {
  const double* strain;
  const double* last;
  const double* before;
  double* stress;
  double* tangent;
  double* energy;
};

TENTER_KERNEL void steps(const double* p, int count, const Eights& arrays) {
  const double a = p[0], c = p[2], tau = p[3];
  const double per_tau = 1.0 / tau;
  for (int k = 0; k < count; k += kLanes) {
    const Lanes e1 = load(arrays.strain + k), e0 = load(arrays.last + k);
    const Lanes s0 = load(arrays.before + k);
    const Lanes one = 1.0 + 0.0 * e1;
    const Lanes s = e1 >= e0 ? one : -one;
    const Lanes b = (e0 + e1 >= 0.0 * e1 ? one : -one) * p[1];
    const Lanes decay = exponential(-s * (e1 - e0) * per_tau);
    // G(e1) - G(e0) and the offset of sigma from g, as in dahl.cpp
    const Lanes curved = (2.0 * c * tau * tau) * s;
    const Lanes g0 = s * (a + e0 * (b + c * e0)) - tau * (b + 2.0 * c * e0) + curved;
    const Lanes g1 = s * (a + e1 * (b + c * e1)) - tau * (b + 2.0 * c * e1) + curved;
    const Lanes offset = (s0 - g0) * decay;
    store(g1 + offset, arrays.stress + k);
    store(s * (b + 2.0 * c * e1) - 2.0 * c * tau - s * per_tau * offset, arrays.tangent + k);
    const Lanes area1 =
        s * e1 * (a + e1 * (0.5 * b + (c / 3.0) * e1)) - tau * e1 * (b + c * e1) + curved * e1;
    const Lanes area0 =
        s * e0 * (a + e0 * (0.5 * b + (c / 3.0) * e0)) - tau * e0 * (b + c * e0) + curved * e0;
    store(load(arrays.energy + k) + area1 - area0 + (s * tau) * ((s0 - g0) - offset),
          arrays.energy + k);
  }
}

}  // namespace

void DahlLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  constexpr int kAtOnce = 64;
  for (int first = 0; first < batch.count; first += kAtOnce) {
    const int count = std::min(kAtOnce, batch.count - first);
    double energy[kAtOnce] = {};
    for (int i = 0; i < strain_count(); ++i) {
      // what is beyond `count` stays at rest
      double strain[kAtOnce] = {}, last[kAtOnce] = {}, before[kAtOnce] = {};
      double stress[kAtOnce], tangent[kAtOnce], sum[kAtOnce];
      std::copy_n(batch.strain[i] + first, count, strain);
      if (batch.state[0]) {
        std::copy_n(batch.state[2 * i] + first, count, before);
        std::copy_n(batch.state[2 * i + 1] + first, count, last);
      }
      std::copy_n(energy, kAtOnce, sum);
      steps(parameters, (count + kLanes - 1) / kLanes * kLanes,
            {strain, last, before, stress, tangent, sum});
      for (int e = 0; e < count; ++e) {
        if (!(strain[e] * last[e] < 0.0)) continue;
        const DahlStep step = dahl_step(last[e], before[e], strain[e], parameters);
        stress[e] = step.stress;
        tangent[e] = step.by_e1;
        sum[e] = energy[e] + step.potential;
      }
      std::copy_n(sum, kAtOnce, energy);
      std::copy_n(stress, count, batch.stress[i] + first);
      if (batch.end_state[0]) {
        std::copy_n(stress, count, batch.end_state[2 * i] + first);
        std::copy_n(strain, count, batch.end_state[2 * i + 1] + first);
      }
      if (!batch.tangent[0][0]) continue;
      std::copy_n(tangent, count, batch.tangent[i][i] + first);
      for (int j = i + 1; j < strain_count(); ++j)
        std::fill_n(batch.tangent[i][j] + first, count, 0.0);
    }
    if (batch.energy) std::copy_n(energy, count, batch.energy + first);
  }
}

}  // namespace tenter::mechanics
