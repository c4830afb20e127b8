// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/stiffening.h"

#include <cmath>

namespace tenter::mechanics {

void CrossModalLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double c = in.parameters[0];
  const double a = in.strain[0];
  const double b = in.strain[1];
  out.energy = 0.5 * c * a * a * b * b;
  out.stress[0] = c * a * b * b;
  out.stress[1] = c * a * a * b;
  out.tangent[0][0] = c * b * b;
  out.tangent[1][1] = c * a * a;
  out.tangent[0][1] = out.tangent[1][0] = 2.0 * c * a * b;
  out.stress_by_parameter[0][0] = a * b * b;
  out.stress_by_parameter[1][0] = a * a * b;
}

void StrainLimitLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k = in.parameters[0];
  for (int i = 0; i < strain_count(); ++i) {
    const double beyond = std::abs(in.strain[i]) - in.parameters[1];
    if (beyond <= 0.0) continue;
    const double sign = in.strain[i] > 0.0 ? 1.0 : -1.0;
    out.energy += 0.5 * k * beyond * beyond;
    out.stress[i] = sign * k * beyond;
    out.tangent[i][i] = k;
    out.stress_by_parameter[i][0] = sign * beyond;
    out.stress_by_parameter[i][1] = -sign * k;
  }
}

}  // namespace tenter::mechanics
