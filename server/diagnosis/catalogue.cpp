// SPDX-License-Identifier: GPL-3.0-or-later
// The catalogue of effects: one row each, in the order of the design table.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

const std::vector<Effect>& catalogue() {
  static const std::vector<Effect> rows = {
      // clang-format off
      nonlinear_stiffness(), strain_limit(), anisotropy(), poisson_coupling(), cross_modal_stiffening(), specimen_scatter(),
      internal_friction(), strain_dependent_friction(), viscosity(),
      plastic_set(), first_cycle_softening(),
      cord_friction(),
      load_cell_offset(), load_cell_gain(), load_cell_drift(), load_cell_saturation(),
      clip_slip(), force_camera_delay(), camera_scale(),
      // clang-format on
  };
  return rows;
}

const std::vector<Effect>& sheet_catalogue() {
  static const std::vector<Effect> rows = [] {
    std::vector<Effect> all = catalogue();
    for (const Effect& effect :
         {rest_shape(), heterogeneity(), camera_pose(), occlusion_bias(), wrong_mass()})
      all.push_back(effect);
    return all;
  }();
  return rows;
}

const Effect* find_effect(const std::string& id) {
  for (const auto* effects : {&catalogue(), &sheet_catalogue()})
    for (const Effect& effect : *effects)
      if (effect.id == id) return &effect;
  return nullptr;
}

}  // namespace tenter::diagnosis
