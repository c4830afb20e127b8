// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/mesh_model.h"

#include <cmath>

#include "server/mechanics/assembly/element_group.h"

namespace tenter::mechanics {

AssemblyStatus MeshModel::evaluate(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                   const ModelOutput& output) const {
  if (output.energy) *output.energy = 0.0;
  if (output.gradient) output.gradient->setZero(3 * node_count_);
  if (output.stiffness) output.stiffness->set_zero();
  for (const auto& group : groups_) {
    const AssemblyStatus status = group->add(x.data(), parameters.data(), output);
    if (status != AssemblyStatus::ok) return status;
  }
  const bool finite = (!output.energy || std::isfinite(*output.energy)) &&
                      (!output.gradient || output.gradient->allFinite()) &&
                      (!output.stiffness || output.stiffness->is_finite());
  return finite ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

AssemblyStatus MeshModel::gradient_by_parameter(const Eigen::VectorXd& x,
                                                const Eigen::VectorXd& parameters,
                                                Eigen::MatrixXd& result) const {
  result.setZero(3 * node_count_, parameter_count_);
  for (const auto& group : groups_) {
    const AssemblyStatus status = group->add_by_parameter(x.data(), parameters.data(), result);
    if (status != AssemblyStatus::ok) return status;
  }
  return result.allFinite() ? AssemblyStatus::ok : AssemblyStatus::not_finite;
}

}  // namespace tenter::mechanics
