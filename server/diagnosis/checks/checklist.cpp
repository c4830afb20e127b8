// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/checklist.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "server/diagnosis/checks/convexity.h"

namespace tenter::diagnosis {
namespace {

void add(Diagnosis& d, const char* level, std::string what, std::string why) {
  d.checklist.push_back({level, std::move(what), std::move(why)});
}

void check_fit(Diagnosis& d) {
  const auto& fit = d.extended.fit;
  add(d, fit.converged ? "OK" : "WARNING",
      fit.converged ? "The fit converged" : "The fit did not converge",
      fit.message + " after " + std::to_string(fit.iterations) + " iterations");
  const auto names = estimation::parameter_names(d.extended.model);
  std::string at_bound;
  std::string unseen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto state = fit.states[i];
    if (state == estimation::ParameterState::at_bound)
      at_bound += (at_bound.empty() ? "" : ", ") + names[i];
    if (state == estimation::ParameterState::zero_gradient ||
        state == estimation::ParameterState::flat)
      unseen += (unseen.empty() ? "" : ", ") + names[i];
  }
  if (!at_bound.empty()) add(d, "WARNING", "Parameters stand at a bound", at_bound);
  if (!unseen.empty()) add(d, "WARNING", "Parameters that these captures do not determine", unseen);
  if (at_bound.empty() && unseen.empty())
    add(d, "OK", "Every parameter is determined", "none at a bound, none flat");
}

void check_energy(Diagnosis& d) {
  const Convexity c = convexity(d.extended.model, *d.data);
  if (c.stable)
    add(d, "OK", "The elastic energy is convex over the strains reached",
        "in the stretches and the shear of the test, at every measured frame");
  else
    add(d, "WARNING", "The elastic energy is not convex everywhere",
        "at " + std::to_string(c.frames) +
            " of the measured frames a stretch that is not held would run away");
  for (const model::Term& term : d.extended.model.terms) {
    if (term.law.name != "dahl") continue;
    const auto& p = term.law.parameters;
    if (p[1].value * p[3].value > 2.0 * p[0].value + 1e-9)
      add(d, "WARNING", "Friction of " + term.id + " may give work back near rest",
          "b tau exceeds twice the friction at zero strain, as in some published materials");
  }
}

void check_data(Diagnosis& d) {
  std::set<estimation::NoiseSource> sources;
  for (const auto& channels : d.noise.channels)
    for (const auto& channel : channels) sources.insert(channel.source);
  std::string words;
  for (const estimation::NoiseSource s : sources)
    words += (words.empty() ? "" : "; ") + std::string(estimation::noise_source_words(s));
  add(d, sources.contains(estimation::NoiseSource::scatter) ? "WARNING" : "OK", "Noise", words);
  for (const estimation::Curves& c : d.curves) {
    if (c.dropped_frames > 0)
      add(d, "WARNING",
          std::to_string(c.dropped_frames) + " frames of \"" + c.title + "\" were dropped",
          "an imposed strain is missing there");
    if (c.time_base == estimation::TimeBase::none)
      add(d, "WARNING", "\"" + c.title + "\" has no time and no rate",
          "effects of rate are at most AMBIGUOUS");
  }
  const int blocks = d.data->block_count();
  if (blocks < 8)
    add(d, "WARNING", "Only " + std::to_string(blocks) + " blocks (branches of loops)",
        "under eight, verdicts carry a weaker word");
  if (d.held_out_kind.empty())
    add(d, "WARNING", "No error on left-out data", "there are too few runs to leave one out");
  else
    add(d, "OK", "Errors on left-out " + d.held_out_kind,
        "each predicted by a fit that did not see it");
}

}  // namespace

void check(Diagnosis& d) {
  check_fit(d);
  check_energy(d);
  check_data(d);
}

}  // namespace tenter::diagnosis
