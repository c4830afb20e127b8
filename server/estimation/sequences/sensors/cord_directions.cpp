// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sensors/cord_directions.h"

#include "server/estimation/sequences/material/captured_material.h"

namespace tenter::estimation {

CordDirections cord_directions(const capture::Sheet& sheet, const capture::ClipTrack& clip,
                               const std::vector<std::size_t>& frames) {
  std::vector<std::pair<std::string, Eigen::Vector3d>> means[2];
  double variation[2] = {0.0, 0.0};
  for (const capture::CordTrack& cord : sheet.cords) {
    if (cord.clip != clip.id) continue;
    for (const std::size_t own : {0U, 1U}) {
      std::vector<Eigen::Vector3d> seen;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const std::size_t f : frames) {
        const Eigen::Vector3d direction = vector_of(cord.direction[f]);
        const Eigen::Matrix3d turn = pose_of(clip.pose[f]).rotation;
        seen.push_back(own == 1 ? Eigen::Vector3d(turn.transpose() * direction) : direction);
        mean += seen.back();
      }
      mean /= static_cast<double>(seen.size());
      for (const Eigen::Vector3d& direction : seen)
        variation[own] += (direction - mean).squaredNorm();
      means[own].emplace_back(cord.id, mean);
    }
  }
  constexpr double kNothing = 1e-12;
  CordDirections known;
  known.turns_with_clip = variation[1] + kNothing < 0.5 * variation[0];
  for (auto [cord, direction] : means[known.turns_with_clip ? 1 : 0]) {
    for (const auto& [name, other] : known.along) direction -= other.dot(direction) * other;
    constexpr double kAdds = 0.2;  // cords nearer to the span of others add nothing of their own
    if (direction.norm() > kAdds) known.along.emplace_back(cord, direction.normalized());
  }
  return known;
}

}  // namespace tenter::estimation
