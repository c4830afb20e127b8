// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/convexity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "common/model/catalogue.h"

namespace tenter::diagnosis {

Convexity convexity(const model::Model& model, const estimation::DataSet& data, double slack) {
  model::Model elastic = model;
  std::erase_if(elastic.terms, [](const model::Term& t) {
    const model::LawRow* row = model::find_law(t.law.name);
    return row && row->path_dependent;
  });
  elastic.corrections.clear();
  Convexity result;
  const auto point = mechanics::MaterialPoint::make(elastic);
  if (!point) return result;
  const Eigen::VectorXd parameters = estimation::parameter_values(elastic);
  for (const estimation::Curves& c : data.curves) {
    const mechanics::HomogeneousStrain kinematics(c.path.axis_angle_rad);
    for (const Eigen::Vector3d& q : c.path.q) {
      const Eigen::Matrix3d hessian = point->elastic_hessian(kinematics, q, parameters);
      const double scale = hessian.cwiseAbs().maxCoeff();
      // a component that nothing resists (no shear term) is no instability
      const bool unstable =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(hessian).eigenvalues()[0] < -slack * scale;
      result.unstable.push_back(unstable);
      if (unstable) ++result.frames;
    }
  }
  result.stable = result.frames == 0;
  return result;
}

int frames_made_unstable(const model::Model& before, const model::Model& after,
                         const estimation::DataSet& data) {
  constexpr double kSlack = 1e-3;
  const Convexity then = convexity(before, data);
  const Convexity now = convexity(after, data, kSlack);
  int frames = 0;
  for (std::size_t f = 0; f < std::min(then.unstable.size(), now.unstable.size()); ++f)
    if (now.unstable[f] && !then.unstable[f]) ++frames;
  return frames;
}

}  // namespace tenter::diagnosis
