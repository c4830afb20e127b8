// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/linear.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

void LinearLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k = in.parameters[0];
  for (int i = 0; i < strain_count(); ++i) {
    out.energy += 0.5 * k * in.strain[i] * in.strain[i];
    out.stress[i] = k * in.strain[i];
    out.tangent[i][i] = k;
    out.stress_by_parameter[i][0] = in.strain[i];
  }
}

void LinearLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double k = parameters[0];
  const int count = batch.count;
  for (int i = 0; i < strain_count(); ++i) {
    const double* __restrict strain = batch.strain[i];
    double* __restrict stress = batch.stress[i];
    for (int e = 0; e < count; ++e) stress[e] = k * strain[e];
  }
  if (batch.energy != nullptr) {
    double* __restrict energy = batch.energy;
    std::fill_n(energy, count, 0.0);
    for (int i = 0; i < strain_count(); ++i) {
      const double* __restrict strain = batch.strain[i];
      for (int e = 0; e < count; ++e) energy[e] += 0.5 * k * strain[e] * strain[e];
    }
  }
  if (batch.tangent[0][0] == nullptr) return;
  for (int i = 0; i < strain_count(); ++i)
    for (int j = i; j < strain_count(); ++j)
      std::fill_n(batch.tangent[i][j], count, i == j ? k : 0.0);
}

void LinearStiffnessLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k1 = in.parameters[0];
  const double k2 = in.parameters[1];
  for (int i = 0; i < strain_count(); ++i) {
    const double strain = in.strain[i];
    const double size = std::abs(strain);
    out.energy += (0.5 * k1 + k2 * size / 3.0) * strain * strain;
    out.stress[i] = (k1 + k2 * size) * strain;
    out.tangent[i][i] = k1 + 2.0 * k2 * size;
    out.stress_by_parameter[i][0] = strain;
    out.stress_by_parameter[i][1] = size * strain;
  }
}

void BilinearLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double c = in.parameters[0];
  out.energy = c * in.strain[0] * in.strain[1];
  for (int i = 0; i < 2; ++i) {
    out.stress[i] = c * in.strain[1 - i];
    out.tangent[i][1 - i] = c;
    out.stress_by_parameter[i][0] = in.strain[1 - i];
  }
}

void BilinearLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double c = parameters[0];
  const int count = batch.count;
  const double* __restrict first = batch.strain[0];
  const double* __restrict second = batch.strain[1];
  double* __restrict stress_1 = batch.stress[0];
  double* __restrict stress_2 = batch.stress[1];
  for (int e = 0; e < count; ++e) {
    stress_1[e] = c * second[e];
    stress_2[e] = c * first[e];
  }
  if (batch.energy != nullptr) {
    double* __restrict energy = batch.energy;
    for (int e = 0; e < count; ++e) energy[e] = c * first[e] * second[e];
  }
  if (batch.tangent[0][0] == nullptr) return;
  std::fill_n(batch.tangent[0][0], count, 0.0);
  std::fill_n(batch.tangent[1][1], count, 0.0);
  std::fill_n(batch.tangent[0][1], count, c);
}

void ConstantStressLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double c = in.parameters[0];
  out.energy = c * in.strain[0];
  out.stress[0] = c;
  out.stress_by_parameter[0][0] = 1.0;
}

void ConstantStressLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double c = parameters[0];
  std::fill_n(batch.stress[0], batch.count, c);
  if (batch.tangent[0][0] != nullptr) std::fill_n(batch.tangent[0][0], batch.count, 0.0);
  if (batch.energy == nullptr) return;
  const double* __restrict strain = batch.strain[0];
  double* __restrict energy = batch.energy;
  for (int e = 0; e < batch.count; ++e) energy[e] = c * strain[e];
}

}  // namespace tenter::mechanics
