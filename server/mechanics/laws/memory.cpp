// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/memory.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

/// Moves the remembered maximum; returns whether this strain is a new one.
bool remember(const LawInput& in, LawOutput& out) {
  const bool grows = in.strain[0] > in.state[0];
  out.state[0] = grows ? in.strain[0] : in.state[0];
  out.state_by_strain[0][0] = grows ? 1.0 : 0.0;
  out.state_by_state[0][0] = grows ? 0.0 : 1.0;
  return grows;
}

}  // namespace

void PlasticSetLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const bool grows = remember(in, out);
  const double c = in.parameters[0];
  const double beyond = out.state[0] - in.parameters[1];
  if (beyond <= 0.0) return;
  out.stress[0] = -c * beyond;
  out.tangent[0][0] = grows ? -c : 0.0;
  out.stress_by_state[0][0] = grows ? 0.0 : -c;
  out.stress_by_parameter[0][0] = -beyond;
  out.stress_by_parameter[0][1] = c;
  if (!grows) {
    out.energy = -c * beyond * in.strain[0];
    return;
  }
  // potential of the step: from the old maximum (or from yield) on, the stress is -c (eps - y)
  const double start = std::max(in.state[0] - in.parameters[1], 0.0);
  out.energy = -0.5 * c * (beyond * beyond - start * start) - c * start * in.state[0];
}

void SofteningLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const bool grows = remember(in, out);
  const double k = in.parameters[0];
  const double scale = in.parameters[1];
  const double e = in.strain[0];
  const double m = std::max(out.state[0], 0.0);
  const double whole = std::exp(-m / scale);
  out.stress[0] = k * e * whole;
  const double by_m = -out.stress[0] / scale;
  out.tangent[0][0] = k * whole + (grows && m > 0.0 ? by_m : 0.0);
  out.stress_by_state[0][0] = grows || m <= 0.0 ? 0.0 : by_m;
  out.stress_by_parameter[0][0] = e * whole;
  out.stress_by_parameter[0][1] = out.stress[0] * m / (scale * scale);
  if (!grows) {
    out.energy = 0.5 * k * e * e * whole;
    return;
  }
  // first loading: stored up to the old maximum, then the integral of k x exp(-x/scale)
  const double m0 = std::max(in.state[0], 0.0);
  const auto integral = [&](double x) { return -k * scale * (x + scale) * std::exp(-x / scale); };
  out.energy = 0.5 * k * m0 * m0 * std::exp(-m0 / scale) + integral(m) - integral(m0);
}

}  // namespace tenter::mechanics
