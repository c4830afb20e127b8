// SPDX-License-Identifier: GPL-3.0-or-later
// One term of Ogden's energy, the same on each strain eps = lambda - 1 (principal stretches):
//
//   Psi = sum_i mu ((lambda_i^alpha - 1)/alpha - ln lambda_i)
//   stress mu (lambda^(alpha-1) - 1/lambda),  tangent mu ((alpha-1) lambda^(alpha-2) + 1/lambda^2)
//
// Since sum_i ln lambda_i = ln J, the second part is the -mu ln J that leaves the rest shape
// without stress. alpha = 0 is the limit, which is no energy at all. Convex at rest where mu alpha
// >= 0.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class OgdenLaw final : public Law {
 public:
  explicit OgdenLaw(int strains) : Law(strains, 2, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

}  // namespace tenter::mechanics
