// SPDX-License-Identifier: GPL-3.0-or-later
// Rate-dependent laws on one or two strains; over a step the strain changes linearly in time.
//
//   maxwell       d sigma/dt = k d eps/dt - sigma/T, exactly:
//                 sigma1 = sigma0 E + k (eps1 - eps0) (1 - E) T/dt,   E = exp(-dt/T)
//                 parameters k (N/m), T = relaxation_time (s)
//   kelvin_voigt  sigma = eta d eps/dt, parameter eta (N s/m)
//
// A step without duration is instantaneous for Maxwell (sigma rises by k d eps) and has no rate for
// Kelvin-Voigt.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class MaxwellLaw final : public Law {
 public:
  explicit MaxwellLaw(int strains) : Law(strains, 2, 2 * strains) {}
  StateKind state_kind(int i) const override {
    return i % 2 == 0 ? StateKind::transient : StateKind::last_strain;
  }
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class KelvinVoigtLaw final : public Law {
 public:
  explicit KelvinVoigtLaw(int strains) : Law(strains, 1, strains) {}
  StateKind state_kind(int) const override { return StateKind::last_strain; }
  bool is_rate() const override { return true; }
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

}  // namespace tenter::mechanics
