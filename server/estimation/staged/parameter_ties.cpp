// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/parameter_ties.h"

#include <cmath>
#include <map>
#include <set>

namespace tenter::estimation {

Eigen::VectorXd ParameterTies::values() const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) q[static_cast<Eigen::Index>(k)] = free[k].value;
  return q;
}

ParameterTies no_ties(const model::Model& model) {
  ParameterTies ties;
  for (const model::Parameter* p : parameters_of(model)) ties.free.push_back(*p);
  const auto count = static_cast<Eigen::Index>(ties.free.size());
  ties.map.setIdentity(count, count);
  return ties;
}

Expected<ParameterTies> tie_terms(const model::Model& model,
                                  const std::vector<std::vector<std::string>>& groups) {
  std::map<std::string, const model::Term*> term_of;
  for (const model::Term& term : model.terms) term_of[term.id] = &term;
  std::map<std::string, std::string> leader_of;
  for (const auto& group : groups) {
    for (const std::string& id : group) {
      if (!term_of.contains(id)) return bad_input("there is no term \"" + id + "\" to tie");
      if (!leader_of.emplace(id, group.front()).second)
        return bad_input("the term \"" + id + "\" is tied twice");
      const model::Law& law = term_of[id]->law;
      const model::Law& first = term_of[group.front()]->law;
      if (law.name != first.name || law.range_lo != first.range_lo ||
          law.range_hi != first.range_hi || law.knots != first.knots ||
          law.parameters.size() != first.parameters.size())
        return bad_input(
            "the terms \"" + group.front() + "\" and \"" + id +
            "\" cannot share a curve: their laws differ in name, range, knots or size");
    }
  }
  ParameterTies ties;
  std::map<std::string, std::size_t> first_of;  // free numbers of a leader
  std::vector<std::size_t> column;
  for (const model::Term& term : model.terms) {
    const auto tied = leader_of.find(term.id);
    const std::string& leader = tied == leader_of.end() ? term.id : tied->second;
    // the leader's numbers, also where another term of the group comes first in the model
    const auto [place, is_new] = first_of.emplace(leader, ties.free.size());
    if (is_new)
      for (const model::Parameter& p : term_of[leader]->law.parameters) ties.free.push_back(p);
    for (std::size_t k = 0; k < term.law.parameters.size(); ++k)
      column.push_back(place->second + k);
  }
  for (const model::SensorCorrection& correction : model.corrections) {
    for (const model::Parameter& p : correction.parameters) {
      column.push_back(ties.free.size());
      ties.free.push_back(p);
    }
  }
  ties.map.setZero(static_cast<Eigen::Index>(column.size()),
                   static_cast<Eigen::Index>(ties.free.size()));
  for (std::size_t i = 0; i < column.size(); ++i)
    ties.map(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(column[i])) = 1.0;
  return ties;
}

mechanics::PathStatus TiedFunction::evaluate(const Eigen::VectorXd& q, Eigen::VectorXd& residuals,
                                             RowMatrix* jacobian) {
  const auto status =
      inner_.evaluate(ties_.all(q), residuals, jacobian ? &inner_jacobian_ : nullptr);
  if (jacobian && status == mechanics::PathStatus::ok) *jacobian = inner_jacobian_ * ties_.map;
  return status;
}

FitResult fit_tied(ResidualFunction& evaluator, const ParameterTies& ties,
                   const FitOptions& options, Eigen::VectorXd* q) {
  // fit() asks a model for nothing but its parameters
  model::Model numbers;
  numbers.terms.emplace_back().law.parameters = ties.free;
  TiedFunction tied(evaluator, ties);
  FitOptions of_numbers = options;
  const auto number_of = [&ties](int parameter) {
    Eigen::Index number = 0;
    ties.map.row(parameter).maxCoeff(&number);
    return static_cast<int>(number);
  };
  for (FrictionPlaces& at : of_numbers.friction)
    at = {number_of(at.a), number_of(at.b), number_of(at.c), number_of(at.tau)};
  FitResult result = fit(tied, numbers, of_numbers);
  if (!result.usable) return result;

  const Eigen::VectorXd errors = result.std_error;
  const RowMatrix covariance = errors.asDiagonal() * result.correlation * errors.asDiagonal();
  const RowMatrix of_all = ties.map * covariance * ties.map.transpose();
  const std::vector<ParameterState> states = std::move(result.states);
  const Eigen::Index count = ties.map.rows();
  if (q) *q = result.parameters;
  result.parameters = ties.all(result.parameters);
  result.jacobian = tied.inner_jacobian();
  result.std_error = of_all.diagonal().cwiseMax(0.0).cwiseSqrt();
  result.correlation.setZero(count, count);
  result.states.assign(static_cast<std::size_t>(count), ParameterState::fixed);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const double scale = result.std_error[i] * result.std_error[k];
      if (scale > 0.0) result.correlation(i, k) = of_all(i, k) / scale;
    }
    // what moves with any free number is free
    for (Eigen::Index k = 0; k < ties.map.cols(); ++k) {
      if (ties.map(i, k) == 0.0) continue;
      ParameterState& state = result.states[static_cast<std::size_t>(i)];
      const ParameterState of_number = states[static_cast<std::size_t>(k)];
      if (state == ParameterState::fixed || of_number == ParameterState::free) state = of_number;
    }
  }
  return result;
}

}  // namespace tenter::estimation
