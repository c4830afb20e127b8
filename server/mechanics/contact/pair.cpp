// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/pair.h"

#include "server/mechanics/contact/edge_edge.h"
#include "server/mechanics/contact/point_triangle.h"

namespace tenter::mechanics {

PairDistance pair_distance(PairKind kind, const FourPoints& x) {
  return kind == PairKind::two_edges ? edge_edge(x) : point_triangle(x);
}

// While both sides go the share s of their ways, less the mean one of all four, their distance
// shrinks by at most s times the sum of the fastest of each.
double free_share(PairKind kind, const FourPoints& from, const FourPoints& to) {
  constexpr double kKept = 0.1;      // of the first distance
  constexpr double kNear = 0.01;     // of it: closer to what is kept counts as there
  constexpr int kMostSteps = 10000;  // grazing motions take many
  const Eigen::Index ones = kind == PairKind::two_edges ? 2 : 1;  // columns of the first side
  FourPoints way = to - from;
  way.colwise() -= way.rowwise().mean().eval();
  const Eigen::RowVector4d speed = way.colwise().norm();
  const double fastest = speed.head(ones).maxCoeff() + speed.tail(4 - ones).maxCoeff();
  const double first = pair_distance(kind, from).distance_m;
  if (first <= 0.0) return 0.0;
  if (fastest < (1.0 - kKept) * first) return 1.0;
  double share = 0.0, distance = first;
  for (int step = 0; step < kMostSteps; ++step) {
    const double left = distance - kKept * first;
    if (left <= kNear * first) return share;
    share += left / fastest;
    if (share >= 1.0) return 1.0;
    distance = pair_distance(kind, from + share * way).distance_m;
  }
  return share;
}

}  // namespace tenter::mechanics
