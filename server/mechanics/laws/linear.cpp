// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/linear.h"

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

void BilinearLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double c = in.parameters[0];
  out.energy = c * in.strain[0] * in.strain[1];
  for (int i = 0; i < 2; ++i) {
    out.stress[i] = c * in.strain[1 - i];
    out.tangent[i][1 - i] = c;
    out.stress_by_parameter[i][0] = in.strain[1 - i];
  }
}

}  // namespace tenter::mechanics
