// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/dissipation.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

GrowthBound bound_at(const Eigen::VectorXd& p, const FrictionPlaces& at) {
  return growth_bound(p[at.a], p[at.c], p[at.tau]);
}

}  // namespace

std::vector<FrictionPlaces> friction_places(const model::Model& model) {
  std::vector<FrictionPlaces> places;
  int first = 0;
  for (const model::Term& term : model.terms) {
    if (term.law.name == "dahl") places.push_back({first, first + 1, first + 2, first + 3});
    first += static_cast<int>(term.law.parameters.size());
  }
  return places;
}

GrowthBound growth_bound(double a, double c, double tau) {
  GrowthBound bound;
  bound.b = 2.0 * a / tau;
  if (!(c > 0.0) || bound.b >= c * tau) {
    bound.by_a = 2.0 / tau;
    bound.by_tau = -2.0 * a / (tau * tau);
    return bound;
  }
  const double square = 4.0 * a * c - c * c * tau * tau;
  bound.b = square > 0.0 ? std::sqrt(square) : 0.0;
  if (bound.b == 0.0) return bound;
  bound.by_a = 2.0 * c / bound.b;
  bound.by_c = (2.0 * a - c * tau * tau) / bound.b;
  bound.by_tau = -c * c * tau / bound.b;
  return bound;
}

std::vector<FrictionPlaces> DissipativeFunction::beyond(const Eigen::VectorXd& parameters) const {
  std::vector<FrictionPlaces> found;
  for (const FrictionPlaces& at : places_) {
    const double most = bound_at(parameters, at).b;
    if (!(parameters[at.b] > most)) continue;
    const auto same = std::find_if(found.begin(), found.end(),
                                   [&](const FrictionPlaces& other) { return other.b == at.b; });
    if (same == found.end())
      found.push_back(at);
    else if (most < bound_at(parameters, *same).b)
      *same = at;
  }
  return found;
}

Eigen::VectorXd DissipativeFunction::bounded(Eigen::VectorXd parameters) const {
  for (const FrictionPlaces& at : beyond(parameters)) parameters[at.b] = bound_at(parameters, at).b;
  return parameters;
}

mechanics::PathStatus DissipativeFunction::evaluate(const Eigen::VectorXd& parameters,
                                                    Eigen::VectorXd& residuals,
                                                    RowMatrix* jacobian) {
  const auto status = inner_.evaluate(bounded(parameters), residuals, jacobian);
  if (!jacobian || status != mechanics::PathStatus::ok) return status;
  for (const FrictionPlaces& at : beyond(parameters)) {
    const GrowthBound bound = bound_at(parameters, at);
    const Eigen::VectorXd by_b = jacobian->col(at.b);
    jacobian->col(at.b).setZero();
    jacobian->col(at.a) += bound.by_a * by_b;
    jacobian->col(at.c) += bound.by_c * by_b;
    jacobian->col(at.tau) += bound.by_tau * by_b;
  }
  return status;
}

}  // namespace tenter::estimation
