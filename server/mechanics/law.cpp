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

namespace {

/// One element of a batch at a time, as evaluate() takes it.
struct OneOfBatch {
  OneOfBatch(const double* parameters, const LawBatch& of, int strains, int states)
      : batch(of), strain_count(strains), state_count(of.state[0] ? states : 0) {
    in.strain = strain;
    in.parameters = parameters;
    in.state = state;
    in.duration_s = of.state[0] ? of.duration_s : 0.0;
  }
  void take(int e) {
    for (int i = 0; i < strain_count; ++i) strain[i] = batch.strain[i][e];
    for (int s = 0; s < state_count; ++s) state[s] = batch.state[s][e];
  }

  const LawBatch& batch;
  int strain_count, state_count;
  double strain[kMaxStrains];
  double state[kMaxLawState] = {};
  LawInput in;
};

}  // namespace

void Law::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  OneOfBatch one(parameters, batch, strain_count_, state_count_);
  one.in.wants_energy = batch.energy != nullptr;
  LawOutput out;
  for (int e = 0; e < batch.count; ++e) {
    one.take(e);
    clear(out);
    evaluate(one.in, out);
    if (batch.energy != nullptr) batch.energy[e] = out.energy;
    for (int i = 0; i < strain_count_; ++i) batch.stress[i][e] = out.stress[i];
    for (int s = 0; batch.end_state[0] && s < state_count_; ++s)
      batch.end_state[s][e] = out.state[s];
    if (batch.tangent[0][0] == nullptr) continue;
    for (int i = 0; i < strain_count_; ++i)
      for (int j = i; j < strain_count_; ++j) batch.tangent[i][j][e] = out.tangent[i][j];
  }
}

void Law::stress_by_parameter_batch(const double* parameters, int parameter,
                                    const LawBatch& batch) const {
  OneOfBatch one(parameters, batch, strain_count_, state_count_);
  one.in.wants_energy = false;
  LawOutput out;
  for (int e = 0; e < batch.count; ++e) {
    one.take(e);
    clear(out);
    evaluate(one.in, out);
    for (int i = 0; i < strain_count_; ++i)
      batch.stress[i][e] = out.stress_by_parameter[i][parameter];
  }
}

}  // namespace tenter::mechanics
