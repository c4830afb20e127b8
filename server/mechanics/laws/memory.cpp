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

/// Integral of x^n exp((x - m)/scale) from 0 to e, by Gauss-Legendre on eight intervals: smooth, no
/// closed form for any n.
double weighted_power_integral(double e, double n, double scale, double m) {
  static constexpr double kNodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                      0.9602898564975363};
  static constexpr double kWeights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                        0.1012285362903763};
  constexpr int kIntervals = 8;
  double sum = 0.0;
  for (int i = 0; i < kIntervals; ++i) {
    const double half = 0.5 * e / kIntervals;
    const double centre = (2 * i + 1) * half;
    for (int k = 0; k < 4; ++k)
      for (const double side : {-1.0, 1.0}) {
        const double x = centre + side * half * kNodes[k];
        sum += kWeights[k] * half * std::pow(x, n) * std::exp((x - m) / scale);
      }
  }
  return sum;
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

// Not the gradient of one potential in the step (the second strain does not move the rest length):
// energy is that of the rest length held, up to a constant.
void CoupledPlasticSetLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const bool grows = remember(in, out);
  const double amplitude[2] = {in.parameters[0], in.parameters[1]};
  const double beyond = out.state[0] - in.parameters[2];
  if (beyond <= 0.0) return;
  for (int i = 0; i < 2; ++i) {
    out.stress[i] = -amplitude[i] * beyond;
    out.energy -= amplitude[i] * beyond * in.strain[i];
    out.tangent[i][0] = grows ? -amplitude[i] : 0.0;
    out.stress_by_state[i][0] = grows ? 0.0 : -amplitude[i];
    out.stress_by_parameter[i][i] = -beyond;
    out.stress_by_parameter[i][2] = amplitude[i];
  }
}

void SofteningLaw::evaluate(const LawInput& in, LawOutput& out) const {
  if (remember(in, out)) return;  // a first loading loses nothing
  const double k = in.parameters[0];
  const double scale = in.parameters[1];
  const double n = in.parameters[2];
  const double e = in.strain[0];
  if (e <= 0.0) return;
  const double below = out.state[0] - e;
  const double near = std::exp(-below / scale);
  const double power = std::pow(e, n);
  out.stress[0] = -k * power * (1.0 - near);
  out.tangent[0][0] = -k * power * n / e * (1.0 - near) + k * power * near / scale;
  out.stress_by_state[0][0] = -k * power * near / scale;
  out.stress_by_parameter[0][0] = -power * (1.0 - near);
  out.stress_by_parameter[0][1] = k * power * near * below / (scale * scale);
  out.stress_by_parameter[0][2] = out.stress[0] * std::log(e);
  if (!in.wants_energy) return;
  out.energy = -k * std::pow(e, n + 1.0) / (n + 1.0) +
               k * weighted_power_integral(e, n, scale, out.state[0]);
}

}  // namespace tenter::mechanics
