// SPDX-License-Identifier: GPL-3.0-or-later
// Exponential fibre: Psi = k/(2 beta) (exp(beta eps^2) - 1), stress k eps exp(beta eps^2); linear
// for beta = 0.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class ExponentialFibreLaw final : public Law {
 public:
  ExponentialFibreLaw() : Law(1, 2, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

}  // namespace tenter::mechanics
