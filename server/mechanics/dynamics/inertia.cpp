// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/inertia.h"

namespace tenter::mechanics {

void Inertia::set(const Boundary& boundary, const Eigen::VectorXd& node_mass_kg,
                  const StepStart& start) {
  const double per_mass = 1.0 / (start.h_s * start.h_s);
  stiffness_N_m_ = per_mass * node_mass_kg;
  const Eigen::Index nodes = 3 * node_mass_kg.size();
  target_m_ = start.target_m.head(nodes);
  clip_springs_.clear();
  for (std::size_t c = 0; c < boundary.clips.size(); ++c) {
    const Clip& clip = boundary.clips[c];
    if (!clip.is_free || clip.mass_kg == 0.0) continue;
    clip_springs_.push_back({static_cast<int>(c), clip.centre_of_mass_m, per_mass * clip.mass_kg,
                             start.target_m.segment<3>(nodes + 3 * static_cast<Eigen::Index>(c))});
  }
}

void Inertia::add(const Eigen::VectorXd& x, const LoadOutput& output, double) const {
  for (Eigen::Index i = 0; i < stiffness_N_m_.size(); ++i) {
    const double k = stiffness_N_m_[i];
    const Eigen::Vector3d off = x.segment<3>(3 * i) - target_m_.segment<3>(3 * i);
    const double energy = 0.5 * k * off.squaredNorm();
    if (output.energy) *output.energy += energy;
    if (output.energy_size) *output.energy_size += energy;
    if (output.gradient) Eigen::Map<Eigen::Vector3d>(output.gradient + 3 * i) += k * off;
    if (!output.stiffness) continue;
    // the diagonal comes first in a column of blocks
    double* block =
        output.stiffness->block(output.stiffness->column_start()[static_cast<std::size_t>(i)]);
    for (int c = 0; c < 3; ++c) block[4 * c] += k;
  }
}

}  // namespace tenter::mechanics
