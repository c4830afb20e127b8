// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/unseen.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/staged/roles.h"

namespace tenter::estimation {

namespace {

bool holds(const std::vector<std::string>& terms, const model::Term& term) {
  return std::find(terms.begin(), terms.end(), term.id) != terms.end();
}

/// sqrt(k_u k_v) at rest; 0 where the model lacks one of these.
double bending_scale(const model::Model& model) {
  double product = 1.0;
  for (const Component component : {Component::bend_u, Component::bend_v}) {
    const auto term = std::find_if(model.terms.begin(), model.terms.end(), [&](const auto& t) {
      return component_of(t) == component && !t.law.parameters.empty();
    });
    if (term == model.terms.end()) return 0.0;
    product *= term->law.parameters[term->law.parameters.size() / 2].value;
  }
  return std::sqrt(std::max(0.0, product));
}

}  // namespace

bool is_seen(const model::Model& model, const std::vector<std::string>& terms,
             const FitResult& result) {
  const double scale = bending_scale(model);
  std::size_t k = 0;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) {
      const double value = result.parameters[static_cast<Eigen::Index>(k)];
      const double error = result.std_error[static_cast<Eigen::Index>(k)];
      const ParameterState state = result.states[k++];
      if (!holds(terms, term) || state == ParameterState::fixed) continue;
      if (state == ParameterState::flat || state == ParameterState::zero_gradient) return false;
      if (state == ParameterState::at_bound && value > p.lower.value_or(value)) return false;
      if (!(2.0 * error < std::max(value, scale))) return false;
    }
  return true;
}

void hold_at(double value, const std::vector<std::string>& terms, model::Model& model) {
  for (model::Term& term : model.terms) {
    if (!holds(terms, term)) continue;
    for (model::Parameter& p : term.law.parameters) {
      p.value = std::clamp(value, p.lower.value_or(value), p.upper.value_or(value));
      p.std_error = p.interval_lo = p.interval_hi = std::nullopt;
      p.fixed = true;
    }
  }
}

bool are_held(const model::Model& model, const std::vector<std::string>& terms) {
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters)
      if (holds(terms, term) && !p.fixed) return false;
  return true;
}

double stand_in(const model::Model& model, const mechanics::SurfaceMesh& mesh) {
  // layers: only a grid with both diagonals has them
  return mesh.triangle_layer.empty() ? bending_scale(model) : 0.0;
}

}  // namespace tenter::estimation
