// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/law.h"

#include <algorithm>

namespace tenter::mechanics {

void Law::clear(LawOutput& out) const {
  out.energy = 0.0;
  for (int i = 0; i < strain_count_; ++i) {
    out.stress[i] = 0.0;
    std::fill_n(out.tangent[i], strain_count_, 0.0);
    std::fill_n(out.stress_by_parameter[i], parameter_count_, 0.0);
    std::fill_n(out.stress_by_state[i], state_count_, 0.0);
  }
  for (int s = 0; s < state_count_; ++s) {
    out.state[s] = 0.0;
    std::fill_n(out.state_by_strain[s], strain_count_, 0.0);
    std::fill_n(out.state_by_parameter[s], parameter_count_, 0.0);
    std::fill_n(out.state_by_state[s], state_count_, 0.0);
  }
}

void Law::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double no_state[kMaxLawState] = {};
  double strain[kMaxStrains];
  LawInput in;
  in.strain = strain;
  in.parameters = parameters;
  in.state = no_state;
  in.wants_energy = batch.energy != nullptr;
  LawOutput out;
  for (int e = 0; e < batch.count; ++e) {
    for (int i = 0; i < strain_count_; ++i) strain[i] = batch.strain[i][e];
    clear(out);
    evaluate(in, out);
    if (batch.energy != nullptr) batch.energy[e] = out.energy;
    for (int i = 0; i < strain_count_; ++i) batch.stress[i][e] = out.stress[i];
    if (batch.tangent[0][0] == nullptr) continue;
    for (int i = 0; i < strain_count_; ++i)
      for (int j = i; j < strain_count_; ++j) batch.tangent[i][j][e] = out.tangent[i][j];
  }
}

void Law::stress_by_parameter_batch(const double* parameters, int parameter,
                                    const LawBatch& batch) const {
  const double no_state[kMaxLawState] = {};
  double strain[kMaxStrains];
  LawInput in;
  in.strain = strain;
  in.parameters = parameters;
  in.state = no_state;
  in.wants_energy = false;
  LawOutput out;
  for (int e = 0; e < batch.count; ++e) {
    for (int i = 0; i < strain_count_; ++i) strain[i] = batch.strain[i][e];
    clear(out);
    evaluate(in, out);
    for (int i = 0; i < strain_count_; ++i)
      batch.stress[i][e] = out.stress_by_parameter[i][parameter];
  }
}

}  // namespace tenter::mechanics
