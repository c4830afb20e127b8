// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/exponential_fibre.h"

#include <cmath>

namespace tenter::mechanics {

void ExponentialFibreLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k = in.parameters[0];
  const double beta = in.parameters[1];
  const double e = in.strain[0];
  const double e2 = e * e;
  const double growth = std::exp(beta * e2);
  // expm1(x)/x -> 1 for x -> 0
  const double x = beta * e2;
  out.energy = 0.5 * k * e2 * (std::abs(x) < 1e-12 ? 1.0 : std::expm1(x) / x);
  out.stress[0] = k * e * growth;
  out.tangent[0][0] = k * growth * (1.0 + 2.0 * x);
  out.stress_by_parameter[0][0] = e * growth;
  out.stress_by_parameter[0][1] = k * e * e2 * growth;
}

}  // namespace tenter::mechanics
