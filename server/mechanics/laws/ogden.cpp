// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/ogden.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

/// With L = ln lambda: expm1 keeps the digits that the difference of the two parts would lose.
struct Stretch {
  Stretch(double strain, double alpha)
      : lambda(std::max(1.0 + strain, kCollapsedStretch)),
        log(lambda == 1.0 + strain ? std::log1p(strain) : std::log(lambda)),
        growth(std::expm1(alpha * log)) {}
  double energy(double alpha) const { return alpha == 0.0 ? 0.0 : growth / alpha - log; }
  double stress() const { return growth / lambda; }
  double tangent(double alpha) const {
    return ((alpha - 1.0) * growth + alpha) / (lambda * lambda);
  }
  double lambda;
  double log;
  double growth;  ///< lambda^alpha - 1
};

}  // namespace

void OgdenLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double mu = in.parameters[0];
  const double alpha = in.parameters[1];
  for (int i = 0; i < strain_count(); ++i) {
    const Stretch s(in.strain[i], alpha);
    out.energy += mu * s.energy(alpha);
    out.stress[i] = mu * s.stress();
    out.tangent[i][i] = mu * s.tangent(alpha);
    out.stress_by_parameter[i][0] = s.stress();
    out.stress_by_parameter[i][1] = mu * s.log * (s.growth + 1.0) / s.lambda;
  }
}

void OgdenLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double mu = parameters[0];
  const double alpha = parameters[1];
  const bool wants_tangent = batch.tangent[0][0] != nullptr;
  if (batch.energy != nullptr) std::fill_n(batch.energy, batch.count, 0.0);
  for (int i = 0; i < strain_count(); ++i) {
    for (int e = 0; e < batch.count; ++e) {
      const Stretch s(batch.strain[i][e], alpha);
      batch.stress[i][e] = mu * s.stress();
      if (wants_tangent) batch.tangent[i][i][e] = mu * s.tangent(alpha);
      if (batch.energy != nullptr) batch.energy[e] += mu * s.energy(alpha);
    }
    for (int j = i + 1; wants_tangent && j < strain_count(); ++j)
      std::fill_n(batch.tangent[i][j], batch.count, 0.0);
  }
}

}  // namespace tenter::mechanics
