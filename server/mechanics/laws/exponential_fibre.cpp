// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/exponential_fibre.h"

#include <cmath>

namespace tenter::mechanics {
namespace {

/// k/2 eps^2 expm1(x)/x with x = beta eps^2; the quotient is 1 at x = 0.
double energy_at(double k, double e2, double x) {
  return 0.5 * k * e2 * (std::abs(x) < 1e-12 ? 1.0 : std::expm1(x) / x);
}

}  // namespace

void ExponentialFibreLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k = in.parameters[0];
  const double beta = in.parameters[1];
  const double e = in.strain[0];
  const double e2 = e * e;
  const double growth = std::exp(beta * e2);
  const double x = beta * e2;
  out.energy = energy_at(k, e2, x);
  out.stress[0] = k * e * growth;
  out.tangent[0][0] = k * growth * (1.0 + 2.0 * x);
  out.stress_by_parameter[0][0] = e * growth;
  out.stress_by_parameter[0][1] = k * e * e2 * growth;
}

void ExponentialFibreLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double k = parameters[0];
  const double beta = parameters[1];
  const double* __restrict strain = batch.strain[0];
  double* __restrict stress = batch.stress[0];
  double* __restrict tangent = batch.tangent[0][0];
  for (int e = 0; e < batch.count; ++e) {
    const double x = beta * strain[e] * strain[e];
    const double stiffness = k * std::exp(x);
    stress[e] = stiffness * strain[e];
    if (tangent != nullptr) tangent[e] = stiffness * (1.0 + 2.0 * x);
  }
  if (batch.energy == nullptr) return;
  for (int e = 0; e < batch.count; ++e) {
    const double e2 = strain[e] * strain[e];
    batch.energy[e] = energy_at(k, e2, beta * e2);
  }
}

}  // namespace tenter::mechanics
