// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl friction on many strains: the formulas of dahl.cpp, eight at a time. A strain that crosses
// zero in its step is rare and goes through dahl_step.
#include <algorithm>

#include "server/mechanics/elements/exponential.h"
#include "server/mechanics/laws/dahl.h"

namespace tenter::mechanics {
namespace {

/// Arrays of a multiple of eight strains; tangent and energy may be null.
struct Eights {
  const double* strain;
  const double* last;
  const double* before;
  double* stress;
  double* tangent;
  double* energy;
  bool adds_energy;
};

/// Whether one crosses zero.
TENTER_KERNEL bool steps(const double* p, int count, const Eights& arrays) {
  const double a = p[0], c = p[2], tau = p[3];
  const double per_tau = 1.0 / tau;
  Lanes lowest{};
  for (int k = 0; k < count; k += kLanes) {
    const Lanes e1 = load(arrays.strain + k), e0 = load(arrays.last + k);
    const Lanes s0 = load(arrays.before + k);
    const Lanes one = 1.0 + 0.0 * e1;
    const Lanes s = e1 >= e0 ? one : -one;
    const Lanes b = (e0 + e1 >= 0.0 * e1 ? one : -one) * p[1];
    const Lanes decay = exponential(-s * (e1 - e0) * per_tau);
    const Lanes side = e0 * e1;
    lowest = side < lowest ? side : lowest;
    // G(e1) - G(e0) and the offset of sigma from g, as in dahl.cpp
    const Lanes curved = (2.0 * c * tau * tau) * s;
    const Lanes g0 = s * (a + e0 * (b + c * e0)) - tau * (b + 2.0 * c * e0) + curved;
    const Lanes g1 = s * (a + e1 * (b + c * e1)) - tau * (b + 2.0 * c * e1) + curved;
    const Lanes offset = (s0 - g0) * decay;
    store(g1 + offset, arrays.stress + k);
    if (arrays.tangent)
      store(s * (b + 2.0 * c * e1) - 2.0 * c * tau - s * per_tau * offset, arrays.tangent + k);
    if (!arrays.energy) continue;
    const Lanes area1 =
        s * e1 * (a + e1 * (0.5 * b + (c / 3.0) * e1)) - tau * e1 * (b + c * e1) + curved * e1;
    const Lanes area0 =
        s * e0 * (a + e0 * (0.5 * b + (c / 3.0) * e0)) - tau * e0 * (b + c * e0) + curved * e0;
    const Lanes area = area1 - area0 + (s * tau) * ((s0 - g0) - offset);
    store(arrays.adds_energy ? load(arrays.energy + k) + area : area, arrays.energy + k);
  }
  double least = 0.0;
  for (int l = 0; l < kLanes; ++l) least = std::min(least, lowest[l]);
  return least < 0.0;
}

/// Any number of strains.
void walk(const double* p, int count, Eights arrays) {
  const auto take = [&p](int many, const Eights& of) {
    double energy[kChunk];
    const int eights = (many + kLanes - 1) / kLanes * kLanes;
    if (of.energy && of.adds_energy) std::copy_n(of.energy, many, energy);
    if (!steps(p, eights, of)) return;
    for (int e = 0; e < many; ++e) {
      if (!(of.strain[e] * of.last[e] < 0.0)) continue;
      const DahlStep step = dahl_step(of.last[e], of.before[e], of.strain[e], p);
      of.stress[e] = step.stress;
      if (of.tangent) of.tangent[e] = step.by_e1;
      if (of.energy) of.energy[e] = step.potential + (of.adds_energy ? energy[e] : 0.0);
    }
  };
  while (count >= kLanes) {
    const int many = std::min(count / kLanes * kLanes, kChunk);
    take(many, arrays);
    arrays.strain += many;
    arrays.last += many;
    arrays.before += many;
    arrays.stress += many;
    if (arrays.tangent) arrays.tangent += many;
    if (arrays.energy) arrays.energy += many;
    count -= many;
  }
  if (count == 0) return;
  // what is beyond the last one stays at rest
  double in[3][kLanes] = {}, out[3][kLanes] = {};
  std::copy_n(arrays.strain, count, in[0]);
  std::copy_n(arrays.last, count, in[1]);
  std::copy_n(arrays.before, count, in[2]);
  if (arrays.energy && arrays.adds_energy) std::copy_n(arrays.energy, count, out[2]);
  take(kLanes, {in[0], in[1], in[2], out[0], arrays.tangent ? out[1] : nullptr,
                arrays.energy ? out[2] : nullptr, arrays.adds_energy});
  std::copy_n(out[0], count, arrays.stress);
  if (arrays.tangent) std::copy_n(out[1], count, arrays.tangent);
  if (arrays.energy) std::copy_n(out[2], count, arrays.energy);
}

}  // namespace

void DahlLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  static constexpr double kRest[kChunk] = {};
  const int at_once = batch.state[0] ? batch.count : kChunk;
  for (int i = 0; i < strain_count(); ++i) {
    for (int first = 0; first < batch.count; first += at_once) {
      const bool has_start = batch.state[0] != nullptr;
      walk(parameters, std::min(at_once, batch.count - first),
           {batch.strain[i] + first, has_start ? batch.state[2 * i + 1] : kRest,
            has_start ? batch.state[2 * i] : kRest, batch.stress[i] + first,
            batch.tangent[0][0] ? batch.tangent[i][i] + first : nullptr,
            batch.energy ? batch.energy + first : nullptr, i > 0});
    }
    if (batch.end_state[0]) {
      std::copy_n(batch.stress[i], batch.count, batch.end_state[2 * i]);
      std::copy_n(batch.strain[i], batch.count, batch.end_state[2 * i + 1]);
    }
    if (!batch.tangent[0][0]) continue;
    for (int j = i + 1; j < strain_count(); ++j) std::fill_n(batch.tangent[i][j], batch.count, 0.0);
  }
}

}  // namespace tenter::mechanics
