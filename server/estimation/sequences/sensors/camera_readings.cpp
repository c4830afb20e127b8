// SPDX-License-Identifier: GPL-3.0-or-later
// Points as cameras show them. With y = x - c, the rotation vector w and its length theta,
//
//   d(R(w) y)/dw = -[R y]x J     J = I + (1 - cos theta)/theta^2 [w]x
//                                    + (theta - sin theta)/theta^3 [w]x^2
#include <cmath>

#include "server/estimation/sequences/sensors/hidden_points.h"
#include "server/estimation/sequences/sensors/sensor_frame.h"

namespace tenter::estimation {

namespace {

/// J: what a change of a rotation vector turns by, seen in space.
Eigen::Matrix3d turn_by_vector(const Eigen::Vector3d& w) {
  constexpr double kSmall = 1e-2;  // below, the next term of the series is beyond double precision
  const double theta = w.norm();
  const double square = theta * theta;
  const double half = theta > 0.0 ? std::sin(0.5 * theta) / theta : 0.5;
  const double first = 2.0 * half * half;
  const double second = theta > kSmall ? (theta - std::sin(theta)) / (square * theta)
                                       : (1.0 - square / 20.0 * (1.0 - square / 42.0)) / 6.0;
  const Eigen::Matrix3d cross = mechanics::cross_matrix(w);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

}  // namespace

void SequenceSensors::show_points(const At& at, Readings& shown) const {
  const Known& known = known_[at.which];
  const auto points = static_cast<Eigen::Index>(at.sequence.points.size());
  const auto each = [&](Type type, const auto& work) {
    for (const Correction& c : corrections_) {
      if (c.type != type || !c.on[at.which]) continue;
      for (Eigen::Index k = 0; k < points; ++k) work(c.first_parameter, k);
    }
  };
  const Eigen::VectorXd& p = at.parameters;
  const Eigen::Vector3d& middle = known.middle_m;
  const auto place = [&](Eigen::Index k) { return shown.value.segment<3>(3 * k); };
  const auto change = [&](Eigen::Index k) { return shown.by_p.middleRows<3>(3 * k); };

  each(Type::occlusion_bias, [&](int own, Eigen::Index k) {
    const double share =
        drawn_share(known.from_hidden[at.frame][static_cast<std::size_t>(k)], p[own + 1]);
    if (share == 0.0) return;
    place(k) += share * p[own] * at.sequence.camera_axis;
    if (at.sensitivities) change(k).col(own) += share * at.sequence.camera_axis;
  });
  each(Type::camera_pose, [&](int own, Eigen::Index k) {
    const Eigen::Vector3d w = p.segment<3>(own);
    const Eigen::Matrix3d turn = mechanics::rotation_of(w);
    const Eigen::Vector3d turned = turn * (place(k) - middle);
    place(k) = middle + turned + p.segment<3>(own + 3);
    if (!at.sensitivities) return;
    for (Eigen::Index q = 0; q < parameter_count_; ++q)
      change(k).col(q) = (turn * change(k).col(q)).eval();
    change(k).middleCols<3>(own) = -mechanics::cross_matrix(turned) * turn_by_vector(w);
    change(k).middleCols<3>(own + 3).setIdentity();
  });
  each(Type::camera_scale, [&](int own, Eigen::Index k) {
    const Eigen::Vector3d from_middle = place(k) - middle;
    place(k) = middle + p[own] * from_middle;
    if (!at.sensitivities) return;
    change(k) *= p[own];
    change(k).col(own) = from_middle;
  });
}

}  // namespace tenter::estimation
