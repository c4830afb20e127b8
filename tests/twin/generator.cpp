// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/generator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iomanip>
#include <sstream>
#include <utility>

#include "tests/twin/capture_writer.h"
#include "tests/twin/hidden_effects.h"
#include "tests/twin/sizing.h"

namespace tenter::twin {
namespace {

Cloth draw_cloth(Random choices, Baseline baseline) {
  const auto about = [&choices](double value) { return value * choices.uniform(0.7, 1.3); };
  Cloth cloth;
  cloth.elastic = {about(600.0), about(800.0), about(150.0), about(100.0)};
  if (baseline == Baseline::stvk_isotropic) {
    cloth.elastic.c22 = cloth.elastic.c11;
    cloth.elastic.c33 = 0.5 * (cloth.elastic.c11 - cloth.elastic.c12);
  }
  if (baseline == Baseline::stvk_diagonal) cloth.elastic.c12 = 0.0;
  return cloth;
}

std::string case_name(const TwinCase& twin_case) {
  std::string name = twin_case.suite;
  for (const std::string& effect : twin_case.effects) name += "+" + effect;
  return name;
}

/// What hides in the captures and how to make them again.
std::string notes_on(const TwinCase& twin_case, const std::vector<Hidden>& hidden) {
  std::ostringstream words;
  words << "synthetic; hidden: ";
  if (hidden.empty()) words << "nothing; ";
  for (const Hidden& effect : hidden) {
    words << effect.id << (effect.variant.empty() ? "" : " (" + effect.variant + ")") << " of "
          << std::setprecision(3) << effect.achieved_size << " times the noise; ";
  }
  words << "suite " << twin_case.suite << ", seed " << twin_case.seed;
  return words.str();
}

}  // namespace

Expected<Twin> make_twin(const TwinCase& twin_case) {
  Random plan_choices(stream_seed(twin_case.seed, case_name(twin_case) + " plan"));
  Expected<std::vector<PlannedCapture>> plans = plan_suite(twin_case.suite, plan_choices);
  if (!plans) return tl::unexpected(plans.error());
  if (!(twin_case.size >= 0.0) || !std::isfinite(twin_case.size))
    return bad_input("the size of a hidden effect must be zero or more");

  std::vector<std::string> ids;
  for (const std::string& name : twin_case.effects) {
    const HiddenEffect* effect = find_hidden_effect(name);
    if (effect == nullptr) return bad_input("the twins know no effect '" + name + "'");
    ids.push_back(effect->id);
  }
  const auto holds = [&ids](const char* id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  if (holds("anisotropy") && holds("poisson_coupling"))
    return bad_input(
        "anisotropy and poisson_coupling are misfits of different baselines: hide one of them");

  const Baseline baseline = baseline_for(ids);
  Random level(stream_seed(twin_case.seed, case_name(twin_case) + " level"));
  NoiseLevels noise;
  noise.stress_N_m = level.log_uniform(0.12, 0.3);
  noise.shear_stress_N_m = 0.3 * noise.stress_N_m;
  const bool declared = level.uniform() < 0.5;

  const Truth plain{
      draw_cloth(Random(stream_seed(twin_case.seed, case_name(twin_case) + " cloth")), baseline),
      {}};
  Truth truth = plain;
  Twin twin;
  if (twin_case.size > 0.0 && !ids.empty()) {
    const Ruler ruler(*plans, plain, baseline, noise);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const std::string& name = twin_case.effects[i];
      const HiddenEffect& effect = *find_hidden_effect(name);
      const Random choices(stream_seed(twin_case.seed, case_name(twin_case) + " effect " + ids[i]));
      const Random taste(stream_seed(twin_case.seed, case_name(twin_case) + " variant " + ids[i]));
      const std::string variant = variant_of(effect, name, taste);
      const auto size_of = [&](double amplitude) {
        Truth alone = plain;
        effect.apply(amplitude, variant, *plans, choices, alone);
        return ruler.size_of(alone);
      };
      const auto [amplitude, size] =
          find_amplitude(effect.first_guess, effect.largest, twin_case.size, size_of);
      effect.apply(amplitude, variant, *plans, choices, truth);
      twin.hidden.push_back(
          {effect.id, variant, amplitude, effect.unit, size, 0.0, effect.foreign});
    }
    if (ids.size() == 1) twin.hidden.front().share_of_force = ruler.share_of_force(truth);
    twin.achieved_size = ids.size() == 1 ? twin.hidden.front().achieved_size : ruler.size_of(truth);
  }

  twin.baseline_preset = preset_name(baseline);
  twin.noise_rms_N_m = noise.stress_N_m;
  twin.sigma_declared = declared;
  const std::string notes = notes_on(twin_case, twin.hidden);
  Random noise_stream(stream_seed(twin_case.seed, case_name(twin_case) + " noise"));
  plans->insert(plans->end(), twin_case.more.begin(), twin_case.more.end());
  for (std::size_t c = 0; c < plans->size(); ++c) {
    twin.captures.push_back(write_down((*plans)[c], twin_case.suite,
                                       measure((*plans)[c], c, truth.cloth, truth.faults), noise,
                                       truth.faults.step_N_m, declared, noise_stream));
    twin.captures.back().provenance.notes = notes;
  }
  return twin;
}

}  // namespace tenter::twin
