// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/point_triangle.h"

namespace tenter::mechanics {

// The nearest point is in one of seven regions (Ericson, Real-Time Collision Detection, 5.1.5):
// told apart by the projections of p on the edges and by the signs of the areas that p cuts off.
PairDistance point_triangle(const FourPoints& x) {
  const Eigen::Vector3d p = x.col(0), a = x.col(1), b = x.col(2), c = x.col(3);
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const double a1 = ab.dot(p - a), a2 = ac.dot(p - a);
  const double b1 = ab.dot(p - b), b2 = ac.dot(p - b);
  const double c1 = ab.dot(p - c), c2 = ac.dot(p - c);
  const double area_c = a1 * b2 - b1 * a2;
  const double area_b = c1 * a2 - a1 * c2;
  const double area_a = b1 * c2 - c1 * b2;
  Eigen::Vector3d w;
  if (a1 <= 0.0 && a2 <= 0.0) {
    w = {1.0, 0.0, 0.0};
  } else if (b1 >= 0.0 && b2 <= b1) {
    w = {0.0, 1.0, 0.0};
  } else if (c2 >= 0.0 && c1 <= c2) {
    w = {0.0, 0.0, 1.0};
  } else if (area_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0) {
    const double v = a1 / (a1 - b1);
    w = {1.0 - v, v, 0.0};
  } else if (area_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0) {
    const double v = a2 / (a2 - c2);
    w = {1.0 - v, 0.0, v};
  } else if (area_a <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0) {
    const double v = (b2 - b1) / ((b2 - b1) + (c1 - c2));
    w = {0.0, 1.0 - v, v};
  } else {
    const double sum = area_a + area_b + area_c;
    w = {area_a / sum, area_b / sum, area_c / sum};
  }
  const Eigen::Vector3d off = p - x.rightCols<3>() * w;
  PairDistance result;
  result.distance_m = off.norm();
  if (result.distance_m > 0.0) result.normal = off / result.distance_m;
  result.weight << 1.0, -w;
  return result;
}

}  // namespace tenter::mechanics
