// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/near_pairs.h"

#include <algorithm>

namespace tenter::mechanics {

void NearPairs::find(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double reach_m) {
  pairs_.clear();
  const auto at = [](const Eigen::VectorXd& x, int node) -> Eigen::Vector3d {
    return x.segment<3>(3 * static_cast<Eigen::Index>(node));
  };
  const Eigen::Map<const Eigen::Matrix3Xd> nodes(from.data(), 3, from.size() / 3);
  Eigen::Index axis = 0;
  (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).maxCoeff(&axis);
  boxes_.resize(triangles_.size());
  double widest = 0.0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    Box& box = boxes_[t];
    box.triangle = static_cast<int>(t);
    box.low = box.high = at(from, triangles_[t][0]);
    for (const int corner : triangles_[t]) {
      box.low = box.low.cwiseMin(at(from, corner)).cwiseMin(at(to, corner));
      box.high = box.high.cwiseMax(at(from, corner)).cwiseMax(at(to, corner));
    }
    widest = std::max(widest, box.high[axis] - box.low[axis]);
  }
  std::sort(boxes_.begin(), boxes_.end(), [axis](const Box& a, const Box& b) {
    return a.low[axis] != b.low[axis] ? a.low[axis] < b.low[axis] : a.triangle < b.triangle;
  });
  const auto count = static_cast<int>(nodes.cols());
  for (int v = 0; v < count; ++v) {
    const Eigen::Vector3d low = at(from, v).cwiseMin(at(to, v)).array() - reach_m;
    const Eigen::Vector3d high = at(from, v).cwiseMax(at(to, v)).array() + reach_m;
    auto box = std::lower_bound(boxes_.begin(), boxes_.end(), low[axis] - widest,
                                [axis](const Box& a, double least) { return a.low[axis] < least; });
    for (; box != boxes_.end() && box->low[axis] <= high[axis]; ++box) {
      if ((box->high.array() < low.array()).any() || (box->low.array() > high.array()).any())
        continue;
      const auto& t = triangles_[static_cast<std::size_t>(box->triangle)];
      if (t[0] == v || t[1] == v || t[2] == v) continue;
      pairs_.push_back({v, t[0], t[1], t[2]});
    }
  }
}

}  // namespace tenter::mechanics
