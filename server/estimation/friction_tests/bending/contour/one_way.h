// SPDX-License-Identifier: GPL-3.0-or-later
// The torque that a piece of strip holds at a strain, after it went one way there: from flat to the
// cylinder, and back (or on) from it; a cantilever from flat.
//
//   T(eps) = least stress between the cylinder's strain and eps on the way back     (snaps: level)
//
// Where the stress falls along the way the piece snaps, under the torque at which it began to fall:
// there T is level over all strains that the snap passes, and a strip, whose weight changes its
// torque as it bends, may rest on any of them. T is continuous and never falls; its tangent is zero
// on a snap. By parameters it moves as the stress does where the snap begins.
//
// One thread per object; refers to point and parameters. Cost: 300 evaluations of the laws to find
// the snaps, one per value.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/friction_tests/strain_point.h"

namespace tenter::estimation {

class OneWay {
 public:
  /// `reach`: snaps are looked for as far as this strain to either side of flat (1/m).
  OneWay(const StrainPoint& point, double anchor, double reach, const Eigen::VectorXd& parameters);

  struct Value {
    double torque = 0.0;   ///< N
    double tangent = 0.0;  ///< by the strain (N m)
    double law_at = 0.0;   ///< strain at which the laws have that torque
    bool is_past = false;  ///< a snap lies between the anchor and here, or it is on one
  };
  Value at(double strain);
  /// Where strain + softness T(strain) is `sum`; from a guess of the strain, which it becomes.
  Value meeting(double sum, double softness, double& strain);
  /// A slope between the law's steepest and its flattest, as strain by torque.
  double softness() const { return softness_; }
  /// Of the torque, by parameters, at Value::law_at. Valid until the next call.
  const Eigen::VectorXd& torque_by_p(double law_at);

 private:
  struct Snap {
    double from = 0.0, to = 0.0;  ///< in the order of the way
    double torque = 0.0;
  };
  void find_snaps(double side, double end);
  void look(double strain, double& torque, double& tangent);

  const StrainPoint& point_;
  const Eigen::VectorXd& parameters_;
  double anchor_;
  double softness_ = 0.0;
  StrainPoint::Walk walk_;
  std::vector<Snap> down_, up_;
};

}  // namespace tenter::estimation
