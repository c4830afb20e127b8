// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/mesh_model.h"

#include <cmath>

#include "server/mechanics/assembly/group.h"

namespace tenter::mechanics {

Eigen::VectorXd term_parameters(const model::Model& model) {
  std::vector<double> values;
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters) values.push_back(p.value);
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

AssemblyStatus MeshModel::evaluate(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                   const ModelOutput& output, const EnergyLimitState* limits,
                                   const History* history) const {
  if (output.energy) *output.energy = 0.0;
  if (output.gradient) output.gradient->setZero(3 * node_count_);
  if (output.stiffness) output.stiffness->set_zero();
  for (const auto& group : groups_) {
    const AssemblyStatus status = group->add(x.data(), parameters.data(), output, limits, history);
    if (status != AssemblyStatus::ok) return status;
  }
  const bool finite = (!output.energy || std::isfinite(*output.energy)) &&
                      (!output.gradient || output.gradient->allFinite()) &&
                      (!output.stiffness || output.stiffness->is_finite());
  return finite ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::gradient_by_parameter(const Eigen::VectorXd& x,
                                                const Eigen::VectorXd& parameters,
                                                Eigen::MatrixXd& result,
                                                const EnergyLimitState* limits,
                                                const History* history) const {
  result.setZero(3 * node_count_, parameter_count_);
  for (const auto& group : groups_) {
    const AssemblyStatus status =
        group->add_by_parameter(x.data(), parameters.data(), limits, history, result);
    if (status != AssemblyStatus::ok) return status;
  }
  if (limits && limited_count_ > 0) {
    ActiveLimits active;
    const AssemblyStatus status = active_limits(x, parameters, *limits, active);
    if (status != AssemblyStatus::ok) return status;
    std::vector<double> measure;
    for (const LimitedElements& limited : limited_)
      measure.insert(measure.end(), limited.measure.begin(), limited.measure.end());
    for (std::size_t k = 0; k < active.entry.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const double weight = limits->penalty * measure[static_cast<std::size_t>(active.entry[k])];
      result.noalias() += weight * active.by_x.col(column) * active.by_parameter.row(column);
    }
  }
  return result.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::active_limits(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                        const EnergyLimitState& limits,
                                        ActiveLimits& active) const {
  active.entry.clear();
  Eigen::VectorXd excess;
  if (const auto status = limit_excess(x, parameters, excess); status != AssemblyStatus::ok)
    return status;
  for (int k = 0; k < limited_count_; ++k)
    if (limits.multiplier[k] + limits.penalty * excess[k] > 0.0) active.entry.push_back(k);
  const auto count = static_cast<Eigen::Index>(active.entry.size());
  active.by_x.setZero(3 * node_count_, count);
  active.by_parameter.setZero(count, parameter_count_);
  if (count == 0) return AssemblyStatus::ok;
  for (const auto& group : groups_) {
    const AssemblyStatus status = group->fill_limits(x.data(), parameters.data(), active);
    if (status != AssemblyStatus::ok) return status;
  }
  return active.by_x.allFinite() && active.by_parameter.allFinite() ? AssemblyStatus::ok
                                                                    : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::term_energies(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                        Eigen::VectorXd& energies, const History* history) const {
  energies.setZero(term_count_);
  for (const auto& group : groups_) {
    const AssemblyStatus status =
        group->add_term_energies(x.data(), parameters.data(), history, energies.data());
    if (status != AssemblyStatus::ok) return status;
  }
  return energies.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::term_strains(const Eigen::VectorXd& x,
                                       std::vector<TermStrains>& strains) const {
  std::size_t used = 0;
  for (int term = 0; term < term_count_; ++term) {
    for (const auto& group : groups_) {
      for (const GroupTerm& part : group->terms) {
        if (part.term != term) continue;
        if (strains.size() == used) strains.emplace_back();
        TermStrains& entry = strains[used++];
        entry.term = term;
        entry.kind = group->kind;
        entry.element = group->element;
        entry.measure = part.measure;
        entry.strains = part.strain->count();
        const AssemblyStatus status = group->strains_of(part, x.data(), entry.strain);
        if (status != AssemblyStatus::ok) return status;
      }
    }
  }
  strains.resize(used);
  return AssemblyStatus::ok;
}

AssemblyStatus MeshModel::limit_excess(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                       Eigen::VectorXd& excess) const {
  excess.resize(limited_count_);
  for (const auto& group : groups_) {
    const AssemblyStatus status = group->limit_excess(x.data(), parameters.data(), excess.data());
    if (status != AssemblyStatus::ok) return status;
  }
  return excess.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

}  // namespace tenter::mechanics
