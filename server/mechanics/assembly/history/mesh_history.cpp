// SPDX-License-Identifier: GPL-3.0-or-later
// MeshModel's functions of the history: history.h, held_step.h.
#include <algorithm>

#include "server/mechanics/assembly/group.h"
#include "server/mechanics/assembly/history/held_step.h"

namespace tenter::mechanics {

Expected<void> check(const History& history, int history_count) {
  if (history.state.size() != history_count)
    return bad_input("the model remembers " + std::to_string(history_count) +
                     " numbers, the history has " + std::to_string(history.state.size()));
  if (!history.state.allFinite() || !(history.duration_s >= 0.0))
    return bad_input("the history has a number that is none, or a step of negative duration");
  if (history.rate_duration_s != 0.0 &&
      (history.rate_state.size() != history_count || !history.rate_state.allFinite() ||
       !(history.rate_duration_s > 0.0)))
    return bad_input("what the history measures rates from is no state with a duration");
  return {};
}

// With d the way from e, ahead: beyond = T(e) d, sigma = sigma(e) + beyond,
// psi = psi(e) + (sigma(e) + beyond/2) d.
void GroupTerm::evaluate_ahead(const double* parameters, const History& history, int first,
                               LawBatch& batch, double* beyond) const {
  const auto elements = static_cast<int>(measure.size());
  const int strains = law->strain_count(), count = batch.count;
  double ahead[kMaxStrains][kChunk] = {}, tangent[kMaxStrains][kMaxStrains][kChunk];
  LawBatch there = batch;
  for (int s = 0, i = 0; s < law->state_count(); ++s) {
    if (law->state_kind(s) != StateKind::last_strain) continue;
    std::copy_n(history.ahead.data() + first_state + s * elements + first, count, ahead[i]);
    there.strain[i] = ahead[i];
    ++i;
  }
  for (int i = 0; i < strains; ++i)
    for (int j = i; j < strains && !batch.tangent[0][0]; ++j) there.tangent[i][j] = tangent[i][j];
  law->evaluate_batch(parameters + first_parameter, there);
  for (int e = 0; e < count; ++e) {
    double way[kMaxStrains], more[kMaxStrains];
    for (int i = 0; i < strains; ++i) way[i] = batch.strain[i][e] - ahead[i][e];
    for (int i = 0; i < strains; ++i) {
      more[i] = 0.0;
      for (int j = 0; j < strains; ++j)
        more[i] += there.tangent[std::min(i, j)][std::max(i, j)][e] * way[j];
      if (batch.energy) batch.energy[e] += (batch.stress[i][e] + 0.5 * more[i]) * way[i];
    }
    for (int i = 0; i < strains; ++i) {
      batch.stress[i][e] += more[i];
      beyond[i * kChunk + e] = more[i];
    }
  }
}

AssemblyStatus MeshModel::end_of_step(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                      const History& history, Eigen::VectorXd& state) const {
  state.resize(history_count_);
  for (const auto& group : groups_) {
    const AssemblyStatus status =
        group->end_of_step(x.data(), parameters.data(), history, state.data());
    if (status != AssemblyStatus::ok) return status;
  }
  return state.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::add_gradient_by_history(const Eigen::VectorXd& x,
                                                  const Eigen::VectorXd& parameters,
                                                  const History& history,
                                                  const Eigen::MatrixXd& change,
                                                  Eigen::MatrixXd& result) const {
  for (const auto& group : groups_) {
    const AssemblyStatus status =
        group->add_by_history(x.data(), parameters.data(), history, change, result);
    if (status != AssemblyStatus::ok) return status;
  }
  return result.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::carry_history_change(const Eigen::VectorXd& x,
                                               const Eigen::VectorXd& parameters,
                                               const History& history,
                                               const Eigen::MatrixXd& x_change,
                                               const std::vector<Eigen::Index>& columns,
                                               Eigen::MatrixXd& change) const {
  for (const auto& group : groups_) {
    const AssemblyStatus status =
        group->carry_change(x.data(), parameters.data(), history, x_change, columns, change);
    if (status != AssemblyStatus::ok) return status;
  }
  return change.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus take_held_step(const MeshModel& model, const Eigen::VectorXd& x,
                              const Eigen::VectorXd& parameters,
                              const std::vector<Eigen::Index>& columns, History& history,
                              Eigen::MatrixXd& change, Eigen::MatrixXd& force) {
  for (const auto& group : MeshModel::Group::of(model)) {
    const AssemblyStatus status =
        group->take_held_step(x.data(), parameters.data(), columns, history, change, force);
    if (status != AssemblyStatus::ok) return status;
  }
  const bool is_finite = force.allFinite() && change.allFinite() && history.state.allFinite();
  return is_finite ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

}  // namespace tenter::mechanics
