// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sheets/sheet_effects.h"

#include <algorithm>
#include <numbers>

namespace tenter::twin {
namespace {

constexpr double kTypicalStrain = 0.06, kTypicalShear = 0.1;

// amplitudes of laws are shares of the stiffness, so that stiff and compliant cloth start alike
double stiffness(const SheetTruth& truth) {
  return truth.fabric.curves[0].stiffness(0.0);
}

// stress of the stiffening term is the amplitude times k e at the typical strain
void stiffen(double amplitude, const std::string& variant, const SheetSuite&, const SheetReadings&,
             Random, SheetTruth& truth) {
  const double cubic = amplitude * stiffness(truth) / (kTypicalStrain * kTypicalStrain);
  if (variant != "v") truth.fabric.hidden.cubic_N_m[0] = cubic;
  if (variant != "u") truth.fabric.hidden.cubic_N_m[1] = cubic;
}

void anisotropy(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
                Random choices, SheetTruth& truth) {
  truth.fabric.curves[1].k[0] *= 1.0 + choices.sign() * amplitude;
}

void poisson(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&, Random,
             SheetTruth& truth) {
  truth.fabric.hidden.coupling_N_m = amplitude * stiffness(truth);
}

void cross_modal(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
                 Random, SheetTruth& truth) {
  truth.fabric.hidden.cross_shear_N_m =
      amplitude * stiffness(truth) / (kTypicalShear * kTypicalShear);
}

void friction_on_both(double a, double b, Random choices, SheetTruth& truth) {
  const double ratio = choices.uniform(0.7, 1.3);
  HiddenLaws& hidden = truth.fabric.hidden;
  hidden.friction_reach = choices.log_uniform(0.003, 0.01);
  hidden.friction_N_m = {a, ratio * a, 0.0};
  hidden.friction_growth_N_m = {b, ratio * b, 0.0};
}

void friction(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
              Random choices, SheetTruth& truth) {
  friction_on_both(amplitude * kTypicalStrain * stiffness(truth), 0.0, choices, truth);
}

void growing_friction(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
                      Random choices, SheetTruth& truth) {
  const double whole = amplitude * stiffness(truth);
  friction_on_both(0.2 * whole * kTypicalStrain, 0.8 * whole, choices, truth);
}

void viscosity(double amplitude, const std::string& variant, const SheetSuite&,
               const SheetReadings&, Random choices, SheetTruth& truth) {
  const double ratio = choices.uniform(0.7, 1.3), k = amplitude * stiffness(truth);
  HiddenLaws& hidden = truth.fabric.hidden;
  if (variant == "kelvin_voigt") {
    hidden.kelvin_voigt_N_s_m = {k, ratio * k};
    return;
  }
  hidden.relaxation_s = choices.log_uniform(1.5, 15.0);
  hidden.maxwell_N_m = {k, ratio * k};
}

void plastic(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
             Random choices, SheetTruth& truth) {
  truth.fabric.hidden.yield_strain = choices.uniform(0.005, 0.02);
  truth.fabric.hidden.plastic_share = {amplitude, choices.uniform(0.7, 1.0) * amplitude};
}

void softening(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
               Random choices, SheetTruth& truth) {
  truth.fabric.hidden.softening_width = choices.uniform(0.003, 0.01);
  truth.fabric.hidden.softening = {amplitude, choices.uniform(0.7, 1.0) * amplitude};
}

void heterogeneity(double amplitude, const std::string& variant, const SheetSuite&,
                   const SheetReadings&, Random choices, SheetTruth& truth) {
  const double side_m = truth.fabric.side_m;
  HiddenLaws& hidden = truth.fabric.hidden;
  hidden.patch_m = {side_m * choices.uniform(0.25, 0.75), side_m * choices.uniform(0.25, 0.75)};
  hidden.patch_reach_m = side_m * choices.uniform(0.15, 0.3);
  hidden.patch_share = variant == "soft" ? -amplitude / (1.0 + amplitude) : amplitude;
}

void mass(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
          Random choices, SheetTruth& truth) {
  truth.faults.mass_factor = choices.uniform() < 0.5 ? 1.0 + amplitude : 1.0 / (1.0 + amplitude);
}

/// Any end, and its largest reading.
double take_cell(bool must_move, const SheetSuite& suite, const SheetReadings& plain,
                 Random& choices, SheetFaults& faults) {
  std::vector<std::string> ends = {"right", "top"};
  if (!must_move) ends.insert(ends.end(), {"left", "bottom"});
  faults.cell = ends[static_cast<std::size_t>(choices.below(static_cast<int>(ends.size())))];
  double largest_N = 0.0;
  for (std::size_t p = 0; p < plain.plans.size(); ++p)
    for (std::size_t k = 0; k < suite.plans[p].cells.size(); ++k)
      if (suite.plans[p].cells[k] == faults.cell)
        for (const SheetReadings::Frame& frame : plain.plans[p])
          largest_N = std::max(largest_N, frame.forces_N[static_cast<Eigen::Index>(k)]);
  return largest_N;
}

void cell_offset(double amplitude, const std::string&, const SheetSuite& suite,
                 const SheetReadings& plain, Random choices, SheetTruth& truth) {
  const double largest_N = take_cell(false, suite, plain, choices, truth.faults);
  truth.faults.offset_N = choices.sign() * amplitude * largest_N;
}

void cell_gain(double amplitude, const std::string&, const SheetSuite& suite,
               const SheetReadings& plain, Random choices, SheetTruth& truth) {
  take_cell(false, suite, plain, choices, truth.faults);
  truth.faults.gain = choices.uniform() < 0.5 ? 1.0 + amplitude : 1.0 / (1.0 + amplitude);
}

// `amplitude` of the largest reading in a minute
void cell_drift(double amplitude, const std::string&, const SheetSuite& suite,
                const SheetReadings& plain, Random choices, SheetTruth& truth) {
  const double largest_N = take_cell(false, suite, plain, choices, truth.faults);
  truth.faults.drift_N_s = choices.sign() * amplitude * largest_N / 60.0;
}

void cord_friction(double amplitude, const std::string&, const SheetSuite& suite,
                   const SheetReadings& plain, Random choices, SheetTruth& truth) {
  take_cell(true, suite, plain, choices, truth.faults);
  truth.faults.cord_friction = amplitude;
}

void cell_saturation(double amplitude, const std::string&, const SheetSuite& suite,
                     const SheetReadings& plain, Random choices, SheetTruth& truth) {
  const double largest_N = take_cell(false, suite, plain, choices, truth.faults);
  truth.faults.cap_N = (1.0 - amplitude) * largest_N;
}

void camera_scale(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
                  Random choices, SheetTruth& truth) {
  truth.faults.scale = 1.0 + choices.sign() * amplitude;
}

Eigen::Vector3d any_way(Random& choices) {
  return Eigen::Vector3d(choices.normal(), choices.normal(), choices.normal()).normalized();
}

// of one capture that is fitted: a turn about any axis, and a shift as large at the sheet's edge
void camera_pose(double amplitude, const std::string&, const SheetSuite& suite,
                 const SheetReadings& plain, Random choices, SheetTruth& truth) {
  const auto any = [&] { return any_way(choices); };
  std::vector<int> fitted;
  for (std::size_t p = 0; p < plain.plans.size(); ++p)
    if (!suite.plans[p].held_out) fitted.push_back(static_cast<int>(p));
  truth.faults.posed_plan =
      fitted[static_cast<std::size_t>(choices.below(static_cast<int>(fitted.size())))];
  truth.faults.turn_rad = amplitude * any();
  truth.faults.shift_m = amplitude * 0.5 * truth.fabric.side_m * any();
}

void occlusion(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
               Random, SheetTruth& truth) {
  truth.faults.occlusion_m = amplitude;
}

// one reading of a hundred, by the amplitude any way in the sheet's plane or out of it
void misread(double amplitude, const std::string&, const SheetSuite& suite, const SheetReadings&,
             Random choices, SheetTruth& truth) {
  constexpr double kShare = 0.01;
  for (std::size_t p = 0; p < suite.plans.size(); ++p)
    for (std::size_t f = 0; f < suite.plans[p].seen.size(); ++f)
      for (std::size_t k = 0; k < suite.places_m.size(); ++k)
        if (choices.uniform() < kShare)
          truth.faults.misread.push_back({static_cast<int>(p), static_cast<int>(f),
                                          static_cast<int>(k), amplitude * any_way(choices)});
}

// in the second half of what a capture does, at the beginning of a leg's frame
void slip(double amplitude, const std::string&, const SheetSuite& suite, const SheetReadings&,
          Random choices, SheetTruth& truth) {
  truth.faults.slip_plan = choices.below(2);
  const SheetPlan& plan = suite.plans[static_cast<std::size_t>(truth.faults.slip_plan)];
  const int frames = static_cast<int>(plan.seen.size());
  truth.faults.slip_frame =
      plan.seen[static_cast<std::size_t>(frames / 3 + choices.below(frames / 3))];
  truth.faults.slip_m = amplitude * truth.fabric.side_m;
}

void delay(double amplitude, const std::string& variant, const SheetSuite&, const SheetReadings&,
           Random, SheetTruth& truth) {
  truth.faults.delay_s = variant == "camera_lags" ? -amplitude : amplitude;
}

void play(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&, Random,
          SheetTruth& truth) {
  truth.faults.play_m = amplitude * truth.fabric.side_m;
}

void expansion(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
               Random choices, SheetTruth& truth) {
  truth.fabric.hidden.expansion = amplitude;
  truth.fabric.hidden.expansion_period_s = choices.uniform(20.0, 45.0);
  truth.fabric.hidden.expansion_phase_rad = choices.uniform(0.0, 2.0 * std::numbers::pi);
}

void clock_aliasing(double amplitude, const std::string&, const SheetSuite&, const SheetReadings&,
                    Random choices, SheetTruth& truth) {
  truth.faults.alias_s = amplitude;
  truth.faults.alias_turns = choices.uniform(0.21, 0.37);
}

}  // namespace

const std::vector<SheetEffect>& sheet_effects() {
  // id, variants, foreign, needs time, is material, needs shear, first guess, largest, unit, apply
  static const std::vector<SheetEffect> effects = {
      {"nonlinear_stiffness",
       {"u", "v", "both"},
       false,
       false,
       true,
       false,
       0.1,
       10.0,
       "k",
       stiffen},
      {"anisotropy", {}, false, false, true, false, 0.1, 0.8, "1", anisotropy},
      {"poisson_coupling", {}, false, false, true, false, 0.1, 0.6, "k", poisson},
      {"cross_modal_stiffening", {}, false, false, true, true, 0.3, 20.0, "k", cross_modal},
      {"internal_friction", {}, false, false, true, false, 0.05, 1.0, "k e", friction},
      {"strain_dependent_friction",
       {},
       false,
       false,
       true,
       false,
       0.05,
       0.8,
       "k",
       growing_friction},
      {"viscosity",
       {"maxwell", "kelvin_voigt"},
       false,
       true,
       true,
       false,
       0.1,
       20.0,
       "k",
       viscosity},
      {"plastic_set", {}, false, false, true, false, 0.05, 0.8, "1", plastic},
      {"first_cycle_softening", {}, false, false, true, false, 0.1, 0.7, "1", softening},
      {"heterogeneity", {"stiff", "soft"}, false, false, true, false, 0.2, 5.0, "1", heterogeneity},
      {"wrong_mass", {}, false, false, false, false, 0.3, 20.0, "1", mass},
      {"load_cell_offset", {}, false, false, false, false, 0.05, 1.0, "largest", cell_offset},
      {"load_cell_gain", {}, false, false, false, false, 0.05, 2.0, "1", cell_gain},
      {"load_cell_drift", {}, false, true, false, false, 0.05, 2.0, "largest a minute", cell_drift},
      {"load_cell_saturation",
       {},
       false,
       false,
       false,
       false,
       0.1,
       0.8,
       "largest",
       cell_saturation},
      {"cord_friction", {}, false, false, false, false, 0.03, 0.5, "1", cord_friction},
      {"clip_slip", {}, false, false, false, false, 0.003, 0.04, "side", slip},
      {"force_camera_delay",
       {"force_lags", "camera_lags"},
       false,
       true,
       false,
       false,
       0.05,
       1.0,
       "s",
       delay},
      {"camera_scale", {}, false, false, false, false, 0.003, 0.08, "1", camera_scale},
      {"camera_pose", {}, false, false, false, false, 0.003, 0.3, "rad", camera_pose},
      {"occlusion_bias", {}, false, false, false, false, 1e-3, 2e-2, "m", occlusion},
      {"outliers", {}, false, false, false, false, 1e-3, 5e-2, "m", misread},
      {"backlash", {}, true, false, false, false, 0.002, 0.03, "side", play},
      {"expansion_cycle", {}, true, true, true, false, 0.003, 0.05, "1", expansion},
      {"clock_aliasing", {}, true, true, false, false, 0.1, 2.0, "s", clock_aliasing},
  };
  return effects;
}

const SheetEffect* find_sheet_effect(const std::string& id) {
  for (const SheetEffect& effect : sheet_effects())
    if (effect.id == id) return &effect;
  return nullptr;
}

bool can_show(const SheetTraits& traits, const SheetEffect& effect) {
  if (effect.needs_time && !traits.has_clock && effect.id != "viscosity") return false;
  if (effect.id == "occlusion_bias" && !traits.has_obstacle) return false;
  return traits.has_shear || !effect.needs_shear;
}

}  // namespace tenter::twin
