// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/viscosity.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

void MaxwellLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double k = in.parameters[0];
  const double relaxation_s = in.parameters[1];
  const double x = in.duration_s / relaxation_s;
  const double decay = std::exp(-x);
  // phi(x) = (1 - exp(-x))/x and its derivative, by series near zero
  const bool small = x < 1e-4;
  const double phi = small ? 1.0 - x / 2.0 + x * x / 6.0 : -std::expm1(-x) / x;
  const double phi_by_x = small ? -0.5 + x / 3.0 : (decay - phi) / x;
  const double x_by_time = -x / relaxation_s;
  for (int i = 0; i < strain_count(); ++i) {
    const int stress = 2 * i;
    const int last = 2 * i + 1;
    const double increment = in.strain[i] - in.state[last];
    const double value = in.state[stress] * decay + k * increment * phi;
    out.energy += increment * (in.state[stress] * decay + 0.5 * k * increment * phi);
    out.stress[i] = out.state[stress] = value;
    out.state[last] = in.strain[i];
    out.tangent[i][i] = out.state_by_strain[stress][i] = k * phi;
    out.state_by_strain[last][i] = 1.0;
    out.stress_by_state[i][stress] = out.state_by_state[stress][stress] = decay;
    out.stress_by_state[i][last] = out.state_by_state[stress][last] = -k * phi;
    const double by_k = increment * phi;
    const double by_time = (-in.state[stress] * decay + k * increment * phi_by_x) * x_by_time;
    out.stress_by_parameter[i][0] = out.state_by_parameter[stress][0] = by_k;
    out.stress_by_parameter[i][1] = out.state_by_parameter[stress][1] = by_time;
  }
}

void KelvinVoigtLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const double eta = in.parameters[0];
  const double per_s = in.duration_s > 0.0 ? 1.0 / in.duration_s : 0.0;
  for (int i = 0; i < strain_count(); ++i) {
    const double rate = (in.strain[i] - in.state[i]) * per_s;
    out.energy += 0.5 * eta * rate * (in.strain[i] - in.state[i]);
    out.stress[i] = eta * rate;
    out.tangent[i][i] = eta * per_s;
    out.stress_by_parameter[i][0] = rate;
    out.stress_by_state[i][i] = -eta * per_s;
    out.state[i] = in.strain[i];
    out.state_by_strain[i][i] = 1.0;
  }
}

void KelvinVoigtLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  const double eta = parameters[0];
  const bool has_rate = batch.state[0] != nullptr && batch.duration_s > 0.0;
  const double per_s = has_rate ? 1.0 / batch.duration_s : 0.0;
  if (batch.energy) std::fill_n(batch.energy, batch.count, 0.0);
  for (int i = 0; i < strain_count(); ++i) {
    for (int e = 0; e < batch.count; ++e) {
      const double strain = batch.strain[i][e];
      const double increment = has_rate ? strain - batch.state[i][e] : 0.0;
      const double stress = eta * per_s * increment;
      batch.stress[i][e] = stress;
      if (batch.energy) batch.energy[e] += 0.5 * stress * increment;
      if (batch.end_state[0]) batch.end_state[i][e] = strain;
    }
    for (int j = i; batch.tangent[0][0] && j < strain_count(); ++j)
      std::fill_n(batch.tangent[i][j], batch.count, i == j ? eta * per_s : 0.0);
  }
}

}  // namespace tenter::mechanics
