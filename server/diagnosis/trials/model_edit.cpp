// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/model_edit.h"

#include <algorithm>

namespace tenter::diagnosis {

model::Model without(const model::Model& model, const std::string& effect,
                     const model::Model& baseline) {
  model::Model result = model;
  std::erase_if(result.terms, [&](const model::Term& t) {
    const bool in_baseline = std::any_of(baseline.terms.begin(), baseline.terms.end(),
                                         [&](const model::Term& b) { return b.id == t.id; });
    return t.effect == effect && !in_baseline;
  });
  for (model::Term& t : result.terms) {
    if (t.effect != effect) continue;
    for (const model::Term& b : baseline.terms)
      if (b.id == t.id) t = b;
  }
  std::erase_if(result.corrections,
                [&](const model::SensorCorrection& c) { return c.effect == effect; });
  // growth of friction with strain lives in the friction terms of another effect
  if (effect == "strain_dependent_friction") {
    for (model::Term& t : result.terms) {
      if (t.law.name != "dahl") continue;
      for (model::Parameter& p : t.law.parameters) {
        if (p.name != "b" && p.name != "c") continue;
        p.value = 0.0;
        p.fixed = true;
      }
    }
  }
  return result;
}

model::Model with_rival(model::Model model, const Trial& rival) {
  for (const model::Term& t : rival.model.terms) {
    if (t.effect != rival.effect->id) continue;
    const bool taken = std::any_of(model.terms.begin(), model.terms.end(),
                                   [&](const model::Term& m) { return m.id == t.id; });
    if (taken) {
      for (model::Term& m : model.terms)
        if (m.id == t.id) m = t;
    } else {
      model.terms.push_back(t);
    }
  }
  for (const model::Field& field : rival.model.fields)  // that supports of its terms refer to
    if (std::none_of(model.fields.begin(), model.fields.end(),
                     [&](const model::Field& own) { return own.id == field.id; }))
      model.fields.push_back(field);
  for (const model::SensorCorrection& c : rival.model.corrections)
    if (c.effect == rival.effect->id) model.corrections.push_back(c);
  return model;
}

std::optional<model::Model> in_plain_form(const Reference& at, const Effect& effect) {
  if (effect.plain_form.empty()) return std::nullopt;
  model::Model plain = at.model;
  const auto names = estimation::parameter_names(at.model);
  bool has_any = false;
  for (model::Term& term : plain.terms) {
    if (term.effect != effect.id) continue;
    has_any = true;
    term.effect = effect.plain_form;
    for (const std::string& ending : effect.hallmarks) {
      for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == term.id + ending && is_surely_there(at.fit, i)) return std::nullopt;
      set_parameter(term.law, ending.substr(1), 0.0, true);
    }
  }
  return has_any ? std::optional(std::move(plain)) : std::nullopt;
}

bool holds(const model::Model& model, const std::string& effect) {
  return std::any_of(model.terms.begin(), model.terms.end(),
                     [&](const model::Term& t) { return t.effect == effect; }) ||
         std::any_of(model.corrections.begin(), model.corrections.end(),
                     [&](const model::SensorCorrection& c) { return c.effect == effect; });
}

}  // namespace tenter::diagnosis
