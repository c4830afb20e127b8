// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/edge_edge.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tenter::mechanics {
namespace {

double share_along(const Eigen::Vector3d& edge, const Eigen::Vector3d& from_its_start) {
  const double squared = edge.squaredNorm();
  return squared > 0.0 ? std::clamp(edge.dot(from_its_start) / squared, 0.0, 1.0) : 0.0;
}

}  // namespace

// Either both nearest points are inside, at the lines' own, or one of them is an end: five
// candidates, of which the nearest is it. With u, v the edges and r = a0 - b0 the lines' own are
//   s = ((u.v)(v.r) - (v.v)(u.r))/c,  t = ((u.u)(v.r) - (u.v)(u.r))/c,  c = |u x v|^2
PairDistance edge_edge(const FourPoints& x) {
  const Eigen::Vector3d u = x.col(1) - x.col(0), v = x.col(3) - x.col(2);
  const Eigen::Vector3d r = x.col(0) - x.col(2);
  double best_s = 0.0, best_t = 0.0;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = -1.0;
  const auto offer = [&](double s, double t) {
    const Eigen::Vector3d off = r + s * u - t * v;
    const double squared = off.squaredNorm();
    if (least >= 0.0 && squared >= least) return;
    least = squared;
    best = off;
    best_s = s;
    best_t = t;
  };
  const double c = u.cross(v).squaredNorm();
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  constexpr double kParallel = 1e-20;  // of c: their own points are made of rounding
  if (c > kParallel * uu * vv) {
    const double ur = u.dot(r), vr = v.dot(r);
    const double s = (uv * vr - vv * ur) / c, t = (uu * vr - uv * ur) / c;
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) offer(s, t);
  }
  offer(0.0, share_along(v, r));
  offer(1.0, share_along(v, r + u));
  offer(share_along(u, -r), 0.0);
  offer(share_along(u, v - r), 1.0);
  PairDistance result;
  result.distance_m = best.norm();
  if (result.distance_m > 0.0) result.normal = best / result.distance_m;
  result.weight = {1.0 - best_s, best_s, best_t - 1.0, -best_t};
  return result;
}

// dc = 2 (u x v).(du x v + u x dv)
EdgeCross edge_cross(const FourPoints& x) {
  const Eigen::Vector3d u = x.col(1) - x.col(0), v = x.col(3) - x.col(2);
  const Eigen::Vector3d across = u.cross(v);
  EdgeCross result;
  result.squared_m4 = across.squaredNorm();
  const Eigen::Vector3d by_u = 2.0 * v.cross(across), by_v = 2.0 * across.cross(u);
  result.slope << -by_u, by_u, -by_v, by_v;
  return result;
}

}  // namespace tenter::mechanics
