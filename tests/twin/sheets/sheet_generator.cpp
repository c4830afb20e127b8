// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sheets/sheet_generator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/twin/sizing.h"

namespace tenter::twin {
namespace {

constexpr double kTolerance = 0.04;  // of sizes

Fabric draw_fabric(Random choices, SheetBaseline baseline) {
  const double k = 60.0 * choices.log_uniform(1.5, 30.0);
  const auto about = [&](double value) { return value * choices.uniform(0.7, 1.3); };
  const auto constant = [](double value) { return StiffnessCurve{0.0, 0.0, {value}}; };
  // stiff enough to stay without wrinkles at the frame's corners, which no coarse grid shows
  const double bend = choices.log_uniform(4e-5, 1.2e-4);
  Fabric fabric;
  fabric.id = "drawn";
  fabric.name = "drawn";
  fabric.mass_kg = about(2e-3);
  fabric.curves = {constant(about(k)),    constant(about(k)),    constant(about(0.35 * k)),
                   constant(about(bend)), constant(about(bend)), constant(about(0.65 * bend))};
  fabric.limits.stretch_u = about(0.07);
  fabric.limits.stretch_v = about(0.07);
  fabric.limits.frame_u = about(0.05);
  fabric.limits.frame_v = about(0.05);
  fabric.limits.shear = about(0.06);
  if (baseline == SheetBaseline::isotropic) {  // lambda a fifth of mu
    const double mu = 0.45 * fabric.curves[0].k[0];
    fabric.curves[1] = fabric.curves[0];
    fabric.curves[2] = constant(mu);
    fabric.hidden.coupling_N_m = fabric.curves[0].k[0] - 2.0 * mu;
  }
  return fabric;
}

/// rms of all forces of the pulls.
double typical_force_N(const SheetReadings& readings) {
  double sum = 0.0, count = 0.0;
  for (const auto& frames : readings.plans)
    for (const auto& frame : frames) {
      sum += frame.forces_N.squaredNorm();
      count += static_cast<double>(frame.forces_N.size());
    }
  return std::sqrt(sum / std::max(1.0, count));
}

void add_noise(const SheetNoise& noise, const Hidden3& hidden, Random random,
               SheetReadings& readings) {
  for (std::size_t p = 0; p < readings.plans.size(); ++p)
    for (std::size_t f = 0; f < readings.plans[p].size(); ++f) {
      SheetReadings::Frame& frame = readings.plans[p][f];
      for (Eigen::Index k = 0; k < frame.points_m.cols(); ++k)
        for (int c = 0; c < 3; ++c) {
          frame.points_m(c, k) += noise.points_m * random.normal();
          if (hidden[p][f][static_cast<std::size_t>(k)])
            frame.points_m(c, k) = std::numeric_limits<double>::quiet_NaN();
        }
      for (double& force_N : frame.forces_N) force_N += noise.forces_N * random.normal();
    }
}

std::string id_of(const std::string& name) {
  return name.substr(0, name.find(':'));
}

/// The form asked for in "id:variant", or one that the choices take.
std::string form_of(const SheetEffect& effect, const std::string& name, Random choices) {
  const std::size_t colon = name.find(':');
  if (colon != std::string::npos) return name.substr(colon + 1);
  if (effect.variants.empty()) return "";
  return effect
      .variants[static_cast<std::size_t>(choices.below(static_cast<int>(effect.variants.size())))];
}

}  // namespace

Expected<SheetTwins> make_sheets(const TwinCase& twin_case, const std::vector<SheetPlan>& more) {
  std::string label = twin_case.suite;
  for (const std::string& name : twin_case.effects) label += "+" + name;
  const auto stream = [&](const std::string& what) {
    return Random(stream_seed(twin_case.seed, label + " " + what));
  };
  SheetTwins twins;
  for (const std::string& name : twin_case.effects) {
    if (find_sheet_effect(id_of(name)) == nullptr)
      return bad_input("sheets know no effect '" + name + "'");
    if (id_of(name) == "anisotropy") twins.baseline = SheetBaseline::isotropic;
  }
  SheetTruth plain{draw_fabric(stream("cloth"), twins.baseline), {}};
  auto suite = plan_sheets(twin_case.suite, plain.fabric, stream("plan"));
  if (!suite) return tl::unexpected(suite.error());
  twins.suite = std::move(*suite);
  twins.stated = plain.fabric;
  Hidden3 hidden = hidden_places(twins.suite, stream("hidden"));
  Random level = stream("level");
  twins.noise.points_m = level.log_uniform(6e-5, 2e-4);
  const double force_share = level.log_uniform(0.006, 0.02);
  twins.guess_k_N_m = plain.fabric.curves[0].k[0] * level.log_uniform(0.5, 2.0);
  SheetTruth truth = plain;
  {
    const auto done = perform(twins.suite, plain.fabric, {}, 2);
    if (!done) return tl::unexpected(done.error());
    twins.noise.forces_N = force_share * typical_force_N(read(twins.suite, *done, hidden, {}));
  }
  twins.stated_noise = {twins.noise.points_m * level.log_uniform(0.5, 2.0),
                        twins.noise.forces_N * level.log_uniform(0.5, 2.0)};
  if (twin_case.size > 0.0 && !twin_case.effects.empty()) {
    const auto ruler = SheetRuler::make(twins.suite, plain, twins.baseline, twins.noise, hidden);
    if (!ruler) return tl::unexpected(ruler.error());
    for (const std::string& name : twin_case.effects) {
      const SheetEffect& effect = *find_sheet_effect(id_of(name));
      if (!can_show(twins.suite.traits, effect))
        return bad_input(twin_case.suite + " cannot show " + effect.id);
      const std::string form = form_of(effect, name, stream("variant " + effect.id));
      SheetSize last;
      const auto apply = [&](double amplitude, SheetTruth& to) {
        effect.apply(amplitude, form, twins.suite, ruler->plain(), stream("effect " + effect.id),
                     to);
        to.is_fabric_plain = to.is_fabric_plain && !effect.is_material;
      };
      const Sized at = find_amplitude(
          effect.first_guess, effect.largest, twin_case.size,
          [&](double amplitude) {
            SheetTruth alone = plain;
            apply(amplitude, alone);
            last = ruler->size_of(alone).value_or(SheetSize{});
            return last.size;
          },
          kTolerance);
      apply(at.amplitude, truth);
      twins.hidden.push_back({effect.id, form, at.amplitude, effect.unit, at.size,
                              last.share_of_force, effect.foreign});
    }
  }
  if (!more.empty()) {
    twins.suite.plans.insert(twins.suite.plans.end(), more.begin(), more.end());
    hidden = hidden_places(twins.suite, stream("hidden"));
  }
  auto done = perform(twins.suite, truth.fabric, truth.faults);
  if (!done) return tl::unexpected(done.error());
  twins.done = std::move(*done);
  twins.readings = read(twins.suite, twins.done, hidden, truth.faults);
  add_noise(twins.noise, hidden, stream("noise"), twins.readings);
  return twins;
}

}  // namespace tenter::twin
