// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/linearised_dahl.h"

#include <cmath>

#include "server/mechanics/laws/dahl.h"

namespace tenter::mechanics {

// With m = sigma_max(eps0), m' its slope, N = m - s0 sigma0 + m' d0 and D = tau + s0 d0, K = N/D:
//   dK/deps0 = (m' + m'' d0)/D    dK/dsigma0 = -s0/D    dK/dd0 = (m' - s0 K)/D    dK/dtau = -K/D
// and by a, b, c:  1/D, (|eps0| + side d0)/D, (eps0^2 + 2 eps0 d0)/D.
void LinearisedDahlLaw::evaluate(const LawInput& in, LawOutput& out) const {
  constexpr int stress = 0, last = 1, before = 2;
  const double* p = in.parameters;
  const double s = in.state[stress], e0 = in.state[last], d0 = in.state[before];
  const double side = e0 < 0.0 ? -1.0 : 1.0;
  const double sign = d0 > 0.0 ? 1.0 : d0 < 0.0 ? -1.0 : 0.0;
  const double most = p[0] + p[1] * std::abs(e0) + p[2] * e0 * e0;
  const double slope = side * p[1] + 2.0 * p[2] * e0;
  const double bottom = p[3] + sign * d0;
  const double k = (most - sign * s + slope * d0) / bottom;
  const double increment = in.strain[0] - e0;
  out.energy += increment * (s + 0.5 * k * increment);
  out.stress[0] = s + k * increment;
  out.tangent[0][0] = k;
  out.stress_by_state[0][stress] = 1.0 - sign / bottom * increment;
  out.stress_by_state[0][last] = (slope + 2.0 * p[2] * d0) / bottom * increment - k;
  out.stress_by_state[0][before] = (slope - sign * k) / bottom * increment;
  out.stress_by_parameter[0][0] = increment / bottom;
  out.stress_by_parameter[0][1] = (std::abs(e0) + side * d0) / bottom * increment;
  out.stress_by_parameter[0][2] = (e0 * e0 + 2.0 * e0 * d0) / bottom * increment;
  out.stress_by_parameter[0][3] = -k / bottom * increment;

  const DahlStep step = dahl_step(e0, s, in.strain[0], p);
  out.state[stress] = step.stress;
  out.state_by_strain[stress][0] = step.by_e1;
  out.state_by_state[stress][stress] = step.by_s0;
  out.state_by_state[stress][last] = step.by_e0;
  for (int q = 0; q < 4; ++q) out.state_by_parameter[stress][q] = step.by_parameter[q];
  out.state[last] = in.strain[0];
  out.state_by_strain[last][0] = 1.0;
  out.state[before] = increment;
  out.state_by_strain[before][0] = 1.0;
  out.state_by_state[before][last] = -1.0;
}

}  // namespace tenter::mechanics
