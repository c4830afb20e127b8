// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/gaussian_energy.h"

#include <cmath>

namespace tenter::mechanics {

GaussianEnergyLaw::GaussianEnergyLaw(int strains, int side, double range_lo, double range_hi)
    : Law(strains, strains == 1 ? side : side * side, 0),
      side_(side),
      lo_(range_lo),
      spacing_((range_hi - range_lo) / (side - 1)) {
  Factor f;
  factor(0.0, f);
  for (int b = 0; b < (strains == 1 ? 1 : side); ++b)
    for (int a = 0; a < side; ++a)
      at_rest_.push_back(f.value[a] * (strains == 1 ? 1.0 : f.value[b]));
}

void GaussianEnergyLaw::factor(double strain, Factor& out) const {
  for (int a = 0; a < side_; ++a) {
    const double x = (strain - (lo_ + a * spacing_)) / spacing_;
    out.value[a] = std::exp(-0.5 * x * x);
    out.first[a] = -x / spacing_ * out.value[a];
    out.second[a] = (x * x - 1.0) / (spacing_ * spacing_) * out.value[a];
  }
}

void GaussianEnergyLaw::evaluate(const LawInput& in, LawOutput& out) const {
  Factor f;
  factor(in.strain[0], f);
  if (strain_count() == 1) {
    for (int a = 0; a < side_; ++a) {
      const double w = in.parameters[a];
      out.energy += w * (f.value[a] - at_rest_[static_cast<std::size_t>(a)]);
      out.stress[0] += w * f.first[a];
      out.tangent[0][0] += w * f.second[a];
      out.stress_by_parameter[0][a] = f.first[a];
    }
    return;
  }
  Factor g;
  factor(in.strain[1], g);
  for (int b = 0; b < side_; ++b) {
    for (int a = 0; a < side_; ++a) {
      const int j = b * side_ + a;
      const double w = in.parameters[j];
      out.energy += w * (f.value[a] * g.value[b] - at_rest_[static_cast<std::size_t>(j)]);
      out.stress_by_parameter[0][j] = f.first[a] * g.value[b];
      out.stress_by_parameter[1][j] = f.value[a] * g.first[b];
      out.stress[0] += w * out.stress_by_parameter[0][j];
      out.stress[1] += w * out.stress_by_parameter[1][j];
      out.tangent[0][0] += w * f.second[a] * g.value[b];
      out.tangent[1][1] += w * f.value[a] * g.second[b];
      out.tangent[0][1] += w * f.first[a] * g.first[b];
    }
  }
  out.tangent[1][0] = out.tangent[0][1];
}

}  // namespace tenter::mechanics
