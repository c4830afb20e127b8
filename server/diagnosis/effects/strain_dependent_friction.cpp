// SPDX-License-Identifier: GPL-3.0-or-later
// Friction whose maximum grows with strain: sigma_max = a + b|eps| + c eps^2 (thesis 5.2.4).
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect strain_dependent_friction() {
  Effect effect = described("strain_dependent_friction");
  effect.hallmarks = {".b", ".c"};
  effect.plain_form = "internal_friction";
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    // friction that is there already gets the growth with strain: linear, then quadratic
    Variant linear;
    linear.words = "sigma_max linear in strain";
    Variant quadratic;
    quadratic.words = "sigma_max quadratic in strain";
    for (const model::Term& term : model.terms) {
      if (term.law.name != "dahl") continue;
      for (const model::Parameter& p : term.law.parameters) {
        if (p.name == "b" && p.fixed) linear.unfix.push_back(term.id + ".b");
        if ((p.name == "b" || p.name == "c") && p.fixed)
          quadratic.unfix.push_back(term.id + "." + p.name);
      }
    }
    if (!linear.unfix.empty()) variants.push_back(linear);
    if (!quadratic.unfix.empty()) variants.push_back(quadratic);
    if (!linear.unfix.empty() || !quadratic.unfix.empty()) return variants;
    for (const auto& group : place_groups(places(model, excitation, true))) {
      Variant variant;
      variant.words = place_words(group);
      model::Model taken = model;
      for (const Place& place : group) {
        model::Term term =
            new_term(taken, "friction_" + place.name, place.measure, place.angle_rad, "dahl");
        set_parameter(term.law, "a", 0.0);
        set_parameter(term.law, "b", 0.0);
        set_parameter(term.law, "tau", 0.1 * place.reach());
        bound_parameter(term.law, "tau", 1e-3 * place.reach(), 3.0 * place.reach());
        taken.terms.push_back(term);
        variant.append.push_back(std::move(term));
      }
      for (const double share : {0.03, 0.12, 0.4}) {
        Setting setting;
        for (std::size_t i = 0; i < group.size(); ++i)
          setting.emplace_back(variant.append[i].id + ".tau", share * group[i].reach());
        variant.grid.push_back(std::move(setting));
      }
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_unloading) return "no run goes back, so nothing lags";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
