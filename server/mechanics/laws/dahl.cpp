// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/dahl.h"

#include <cmath>

namespace tenter::mechanics {
namespace {

// On one side of zero sigma_max = a + B e + c e^2 with B = +-b. A particular solution of s' + s0
// s/tau = sigma_max/tau is
//   g(e) = s sigma_max(e) - tau sigma_max'(e) + s tau^2 sigma_max''
// (s the sign of the increment; s^2 = 1), and so exactly
//   sigma(e1) = g(e1) + (sigma0 - g(e0)) E,   E = exp(-|e1 - e0| / tau).
// The approximation 5.3 keeps only the first term of g. The integral of the stress over the step is
//   [G]_(e0)^(e1) + (sigma0 - g(e0)) s tau (1 - E),   G' = g.
DahlStep one_sided(double e0, double s0, double e1, const double* p, double side) {
  const double a = p[0];
  const double b = side * p[1];
  const double c = p[2];
  const double tau = p[3];
  const double s = e1 >= e0 ? 1.0 : -1.0;
  const double decay = std::exp(-s * (e1 - e0) / tau);

  const auto g = [&](double e) {
    return s * (a + b * e + c * e * e) - tau * (b + 2.0 * c * e) + s * tau * tau * 2.0 * c;
  };
  const auto g_by_e = [&](double e) { return s * (b + 2.0 * c * e) - tau * 2.0 * c; };
  const auto antiderivative = [&](double e) {
    return s * (a * e + 0.5 * b * e * e + c * e * e * e / 3.0) - tau * (b * e + c * e * e) +
           s * tau * tau * 2.0 * c * e;
  };

  DahlStep step;
  const double offset = s0 - g(e0);
  step.stress = g(e1) + offset * decay;
  step.potential = antiderivative(e1) - antiderivative(e0) + offset * s * tau * (1.0 - decay);
  step.by_e1 = g_by_e(e1) - offset * decay * s / tau;
  step.by_e0 = -g_by_e(e0) * decay + offset * decay * s / tau;
  step.by_s0 = decay;

  const double g1[4] = {s, side * (s * e1 - tau),
                        s * e1 * e1 - 2.0 * tau * e1 + 2.0 * s * tau * tau,
                        -(b + 2.0 * c * e1) + 4.0 * s * tau * c};
  const double g0[4] = {s, side * (s * e0 - tau),
                        s * e0 * e0 - 2.0 * tau * e0 + 2.0 * s * tau * tau,
                        -(b + 2.0 * c * e0) + 4.0 * s * tau * c};
  for (int k = 0; k < 4; ++k) step.by_parameter[k] = g1[k] - g0[k] * decay;
  step.by_parameter[3] += offset * decay * s * (e1 - e0) / (tau * tau);
  return step;
}

}  // namespace

DahlStep dahl_step(double e0, double s0, double e1, const double* p) {
  const bool crosses = (e0 < 0.0 && e1 > 0.0) || (e0 > 0.0 && e1 < 0.0);
  if (!crosses) return one_sided(e0, s0, e1, p, e0 + e1 >= 0.0 ? 1.0 : -1.0);
  const DahlStep first = one_sided(e0, s0, 0.0, p, e0 > 0.0 ? 1.0 : -1.0);
  DahlStep second = one_sided(0.0, first.stress, e1, p, e1 > 0.0 ? 1.0 : -1.0);
  // chain the second half on the first; both halves meet at the fixed strain zero
  const double by_s = second.by_s0;
  for (int k = 0; k < 4; ++k) second.by_parameter[k] += by_s * first.by_parameter[k];
  second.by_e0 = by_s * first.by_e0;
  second.by_s0 = by_s * first.by_s0;
  second.potential += first.potential;
  return second;
}

void DahlLaw::evaluate(const LawInput& in, LawOutput& out) const {
  for (int i = 0; i < strain_count(); ++i) {
    const int stress = 2 * i;
    const int last = 2 * i + 1;
    const DahlStep step = dahl_step(in.state[last], in.state[stress], in.strain[i], in.parameters);
    out.energy += step.potential;
    out.stress[i] = step.stress;
    out.tangent[i][i] = step.by_e1;
    out.stress_by_state[i][stress] = step.by_s0;
    out.stress_by_state[i][last] = step.by_e0;
    out.state[stress] = step.stress;
    out.state[last] = in.strain[i];
    out.state_by_strain[stress][i] = step.by_e1;
    out.state_by_strain[last][i] = 1.0;
    out.state_by_state[stress][stress] = step.by_s0;
    out.state_by_state[stress][last] = step.by_e0;
    for (int k = 0; k < 4; ++k) {
      out.stress_by_parameter[i][k] = step.by_parameter[k];
      out.state_by_parameter[stress][k] = step.by_parameter[k];
    }
  }
}

}  // namespace tenter::mechanics
