// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/hidden_effects.h"

#include <algorithm>
#include <cstddef>
#include <numbers>

namespace tenter::twin {
namespace {

using Plans = std::vector<PlannedCapture>;

constexpr double kTypicalStrain = 0.08;

// stress of the stiffening term is `amplitude` N/m at 8 % strain
void stiffen(double amplitude, const std::string& variant, const Plans&, Random, Truth& truth) {
  const double cubic = amplitude / (kTypicalStrain * kTypicalStrain * kTypicalStrain);
  if (variant != "v") truth.cloth.cubic[0] = cubic;
  if (variant != "u") truth.cloth.cubic[1] = cubic;
}

// stress of the limit is `amplitude` N/m at 8 % strain
void limit(double amplitude, const std::string& variant, const Plans&, Random choices,
           Truth& truth) {
  truth.cloth.strain_limit = choices.uniform(0.04, 0.065);
  const double taut = amplitude / (kTypicalStrain - truth.cloth.strain_limit);
  if (variant != "v") truth.cloth.taut[0] = taut;
  if (variant != "u") truth.cloth.taut[1] = taut;
}

void anisotropy(double amplitude, const std::string&, const Plans&, Random choices, Truth& truth) {
  truth.cloth.elastic.c22 *= 1.0 + choices.sign() * amplitude;
}

void poisson(double amplitude, const std::string&, const Plans&, Random, Truth& truth) {
  truth.cloth.elastic.c12 = amplitude;
}

void friction_on_both_axes(double a, double b, bool fibre, Random choices, Truth& truth) {
  const double tau = choices.log_uniform(0.005, 0.015);
  const double ratio = choices.uniform(0.7, 1.3);
  truth.cloth.friction.push_back({0.0, a, b, tau});
  truth.cloth.friction.push_back({std::numbers::pi / 2.0, ratio * a, ratio * b, tau});
  if (fibre) {
    truth.cloth.friction.push_back({std::numbers::pi / 4.0, 0.5 * a, 0.5 * b, tau});
    truth.cloth.friction.push_back({-std::numbers::pi / 4.0, 0.5 * a, 0.5 * b, tau});
  }
}

void friction(double amplitude, const std::string& variant, const Plans&, Random choices,
              Truth& truth) {
  friction_on_both_axes(amplitude, 0.0, variant == "fibres", choices, truth);
}

// sigma_max grows from a fifth to its full amplitude at 8 % strain
void growing_friction(double amplitude, const std::string&, const Plans&, Random choices,
                      Truth& truth) {
  friction_on_both_axes(0.2 * amplitude, 0.8 * amplitude / kTypicalStrain, false, choices, truth);
}

void viscosity(double amplitude, const std::string& variant, const Plans&, Random choices,
               Truth& truth) {
  const double ratio = choices.uniform(0.7, 1.3);
  if (variant == "kelvin_voigt") {
    truth.cloth.kelvin_voigt = {amplitude, ratio * amplitude};
    return;
  }
  truth.cloth.relaxation_time_s = choices.log_uniform(2.0, 20.0);
  truth.cloth.maxwell = {amplitude, ratio * amplitude};
}

void plastic(double amplitude, const std::string&, const Plans&, Random choices, Truth& truth) {
  truth.cloth.yield_strain = choices.uniform(0.005, 0.02);
  truth.cloth.plastic_share = {amplitude, choices.uniform(0.7, 1.0) * amplitude};
}

void softening(double amplitude, const std::string&, const Plans&, Random choices, Truth& truth) {
  truth.cloth.softening_width = choices.uniform(0.003, 0.01);
  truth.cloth.softening = {amplitude, choices.uniform(0.7, 1.0) * amplitude};
}

// stress in either stretch is `amplitude` N/m where both modes are at 5 %
void cross_modal(double amplitude, const std::string& variant, const Plans&, Random, Truth& truth) {
  const double c = amplitude / (0.05 * 0.05 * 0.05);
  (variant == "shear" ? truth.cloth.cross_shear : truth.cloth.cross_stretch) = c;
}

void specimens_differ(double amplitude, const std::string&, const Plans& plans, Random choices,
                      Truth& truth) {
  int specimens = 0;
  for (const PlannedCapture& plan : plans) specimens = std::max(specimens, plan.specimen);
  truth.cloth.specimen_factors.clear();
  for (int i = 0; i < specimens; ++i) {
    const double up = 1.0 + amplitude * choices.uniform(0.3, 1.0);
    truth.cloth.specimen_factors.push_back(choices.uniform() < 0.5 ? up : 1.0 / up);
  }
}

std::size_t cell_of(const std::string& variant) {
  return variant == "y" ? 1 : 0;
}

void cell_offset(double amplitude, const std::string& variant, const Plans&, Random choices,
                 Truth& truth) {
  truth.faults.offset_N_m[cell_of(variant)] = choices.sign() * amplitude;
}

void cell_gain(double amplitude, const std::string& variant, const Plans&, Random choices,
               Truth& truth) {
  const double up = 1.0 + amplitude;
  truth.faults.gain[cell_of(variant)] = choices.uniform() < 0.5 ? up : 1.0 / up;
}

void cell_drift(double amplitude, const std::string& variant, const Plans&, Random choices,
                Truth& truth) {
  truth.faults.drift_N_m_s[cell_of(variant)] = choices.sign() * amplitude;
}

void cord_friction(double amplitude, const std::string& variant, const Plans&, Random,
                   Truth& truth) {
  truth.faults.cord_friction[cell_of(variant)] = amplitude;
}

// `amplitude` N/m below what a sound cell would show at its largest
void cell_saturation(double amplitude, const std::string& variant, const Plans& plans, Random,
                     Truth& truth) {
  const std::size_t cell = cell_of(variant);
  double largest = 0.0;
  for (std::size_t c = 0; c < plans.size(); ++c) {
    const Readings sound = measure(plans[c], c, truth.cloth, truth.faults);
    for (const double value : cell == 1 ? sound.stress_y : sound.stress_x)
      largest = std::max(largest, value);
  }
  truth.faults.cap_N_m[cell] = largest - amplitude;
}

void cell_steps(double amplitude, const std::string& variant, const Plans&, Random, Truth& truth) {
  truth.faults.step_N_m[cell_of(variant)] = amplitude;
}

// changes of length shown too large; a few per cent of one free stretch, so that it takes much
void camera_scale(double amplitude, const std::string& variant, const Plans&, Random choices,
                  Truth& truth) {
  truth.faults.camera_scale =
      variant == "lengths" ? 1.0 + choices.sign() * amplitude : 1.0 + amplitude;
  truth.faults.camera_rest = variant == "lengths" ? 0.0 : 1.0;
}

// in the middle of a pull of the first capture, in any run but its first
void clip_slip(double amplitude, const std::string&, const Plans& plans, Random choices,
               Truth& truth) {
  const PlannedCapture& plan = plans.front();
  const int runs = static_cast<int>(plan.runs.size());
  truth.faults.slip_run = runs > 1 ? 1 + choices.below(runs - 1) : 0;
  std::vector<std::size_t> candidates;
  double peak = 0.0;
  for (const PlannedFrame& frame : plan.frames) peak = std::max(peak, frame.strain_x);
  for (std::size_t i = 0; i < plan.frames.size(); ++i) {
    const PlannedFrame& frame = plan.frames[i];
    if (frame.run == truth.faults.slip_run && frame.branch == capture::Branch::load &&
        frame.strain_x > 0.3 * peak && frame.strain_x < 0.7 * peak)
      candidates.push_back(i);
  }
  if (candidates.empty()) return;
  truth.faults.slip_frame =
      candidates[static_cast<std::size_t>(choices.below(static_cast<int>(candidates.size())))];
  truth.faults.slip_strain = amplitude;
}

void delay(double amplitude, const std::string& variant, const Plans&, Random, Truth& truth) {
  truth.faults.force_delay_s = variant == "camera_lags" ? -amplitude : amplitude;
}

void outliers(double amplitude, const std::string&, const Plans&, Random choices, Truth& truth) {
  truth.faults.outlier_N_m = amplitude;
  truth.faults.outlier_seed = static_cast<std::uint64_t>(choices.below(1 << 30));
}

void backlash(double amplitude, const std::string&, const Plans&, Random, Truth& truth) {
  truth.faults.backlash_strain = amplitude;
}

void expansion(double amplitude, const std::string&, const Plans&, Random choices, Truth& truth) {
  truth.faults.expansion_strain = amplitude;
  truth.faults.expansion_period_s = choices.uniform(90.0, 260.0);
  truth.faults.expansion_phase_rad = choices.uniform(0.0, 2.0 * std::numbers::pi);
}

void creep_to_failure(double amplitude, const std::string&, const Plans&, Random, Truth& truth) {
  truth.cloth.creep_per_s = amplitude;
}

void clock_aliasing(double amplitude, const std::string&, const Plans&, Random choices,
                    Truth& truth) {
  truth.faults.clock_alias_s = amplitude;
  truth.faults.clock_alias_frames = choices.uniform(0.11, 0.19);
}

}  // namespace

const std::vector<HiddenEffect>& hidden_effects() {
  // id, variants, foreign, needs time, needs loops, first guess, largest, unit, apply
  static const std::vector<HiddenEffect> effects = {
      {"nonlinear_stiffness",
       {"u", "v", "both"},
       false,
       false,
       false,
       5.0,
       1e4,
       "N/m at 8 %",
       stiffen},
      {"strain_limit", {"u", "v", "both"}, false, false, false, 5.0, 1e4, "N/m at 8 %", limit},
      {"anisotropy", {}, false, false, false, 0.1, 0.9, "1", anisotropy},
      {"poisson_coupling", {}, false, false, false, 50.0, 500.0, "N/m", poisson},
      {"cross_modal_stiffening",
       {"stretches", "shear"},
       false,
       false,
       false,
       2.0,
       1e4,
       "N/m at 5 %",
       cross_modal},
      {"specimen_scatter", {}, false, false, false, 0.1, 2.0, "1", specimens_differ, true},
      {"internal_friction",
       {"axes", "axes", "fibres"},
       false,
       false,
       true,
       1.0,
       300.0,
       "N/m",
       friction},
      {"strain_dependent_friction",
       {},
       false,
       false,
       true,
       2.0,
       300.0,
       "N/m at 8 %",
       growing_friction},
      {"viscosity",
       {"maxwell", "maxwell", "kelvin_voigt"},
       false,
       true,
       true,
       50.0,
       1e5,
       "N/m or N s/m",
       viscosity},
      {"plastic_set", {}, false, false, true, 0.1, 0.9, "1", plastic},
      {"first_cycle_softening", {}, false, false, false, 0.1, 0.7, "1", softening},
      {"load_cell_offset", {"x", "y"}, false, false, false, 1.0, 1e3, "N/m", cell_offset},
      {"load_cell_gain", {"x", "y"}, false, false, false, 0.1, 2.0, "1", cell_gain},
      {"load_cell_drift", {"x", "y"}, false, true, false, 0.001, 1.0, "N/m/s", cell_drift},
      {"cord_friction", {"x", "y"}, false, false, true, 0.02, 0.5, "1", cord_friction},
      {"load_cell_saturation", {"x", "y"}, false, false, false, 5.0, 40.0, "N/m", cell_saturation},
      {"load_cell_quantisation", {"x", "y"}, false, false, false, 1.0, 40.0, "N/m", cell_steps},
      {"camera_scale", {"changes", "lengths"}, false, false, false, 0.01, 0.95, "1", camera_scale},
      {"clip_slip", {}, false, false, false, 0.005, 0.03, "1", clip_slip},
      {"force_camera_delay",
       {"force_lags", "force_lags", "camera_lags"},
       false,
       true,
       true,
       0.2,
       5.0,
       "s",
       delay},
      {"outliers", {}, false, false, false, 10.0, 1e3, "N/m", outliers},
      {"backlash", {}, true, false, true, 0.001, 0.01, "1", backlash},
      {"expansion_cycle", {}, true, false, false, 0.001, 0.05, "1", expansion},
      {"creep_to_failure", {}, true, true, false, 1e-4, 0.1, "1/s at 8 %", creep_to_failure},
      {"clock_aliasing", {}, true, false, true, 0.2, 5.0, "s", clock_aliasing},
  };
  return effects;
}

const HiddenEffect* find_hidden_effect(const std::string& name) {
  const std::size_t colon = name.find(':');
  const std::string id = name.substr(0, colon);
  for (const HiddenEffect& effect : hidden_effects()) {
    if (effect.id != id) continue;
    if (colon == std::string::npos) return &effect;
    const std::string variant = name.substr(colon + 1);
    const bool known =
        std::find(effect.variants.begin(), effect.variants.end(), variant) != effect.variants.end();
    return known ? &effect : nullptr;
  }
  return nullptr;
}

std::string variant_of(const HiddenEffect& effect, const std::string& name, Random choices) {
  const std::size_t colon = name.find(':');
  if (colon != std::string::npos) return name.substr(colon + 1);
  if (effect.variants.empty()) return "";
  return effect
      .variants[static_cast<std::size_t>(choices.below(static_cast<int>(effect.variants.size())))];
}

}  // namespace tenter::twin
