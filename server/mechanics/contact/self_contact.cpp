// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "server/mechanics/contact/edge_edge.h"

namespace tenter::mechanics {
namespace {

constexpr double kFarFromAnything_m = 1e100;

bool is_somewhere(const Eigen::VectorXd& x) {
  return x.allFinite() && x.lpNorm<Eigen::Infinity>() < kFarFromAnything_m;
}

/// m of self_contact.h.
struct Fade {
  double value = 1.0;
  double slope = 0.0;  ///< dm/dc
};
Fade fade(double c, double squares_m4) {
  const double e = 1e-3 * squares_m4;
  if (c >= e) return {};
  return {(2.0 - c / e) * c / e, 2.0 * (1.0 - c / e) / e};
}

/// What turning an edge does to c, of each node by itself: c is at most 4 |v|^2 times the squares
/// of the two ends' ways across v, and as much for the other edge.
Eigen::Matrix3d turn_stiffness(const FourPoints& x, Eigen::Index column) {
  const Eigen::Vector3d other = column < 2 ? x.col(3) - x.col(2) : x.col(1) - x.col(0);
  return 4.0 * (other.squaredNorm() * Eigen::Matrix3d::Identity() - other * other.transpose());
}

double smallest_height_m(const SurfaceMesh& mesh) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector2d ab = mesh.way_m(t[0], t[1]), ac = mesh.way_m(t[0], t[2]);
    const double twice_area = std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    smallest = std::min(smallest, twice_area / std::max({ab.norm(), ac.norm(), (ac - ab).norm()}));
  }
  return smallest;
}

}  // namespace

Expected<SelfContact> SelfContact::make(const SurfaceMesh& mesh, double thickness_m,
                                        double stiffness_N_m) {
  if (!(thickness_m > 0.0) || !std::isfinite(thickness_m))
    return bad_input("the thickness of self-contact is " + std::to_string(thickness_m) +
                     " m and must be positive");
  if (!(stiffness_N_m > 0.0) || !std::isfinite(stiffness_N_m))
    return bad_input("the stiffness of self-contact must be positive");
  if (const double height = smallest_height_m(mesh); thickness_m > 0.5 * height)
    return bad_input("the thickness of self-contact is " + std::to_string(thickness_m) +
                     " m, more than half of the smallest height of a triangle, " +
                     std::to_string(height) + " m");
  SelfContact contact;
  contact.pairs_ = NearPairs(mesh);
  contact.thickness_m_ = thickness_m;
  contact.stiffness_N_m_ = stiffness_N_m;
  return contact;
}

void SelfContact::begin(const Eigen::VectorXd& x) {
  pairs_.find(x, x, thickness_m_);
}

double SelfContact::longest_fraction(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  if (!is_somewhere(to)) return 0.0;
  pairs_.find(from, to, thickness_m_);
  double share = 1.0;
  for (const ContactPair& pair : pairs_.list())
    share = std::min(share, free_share(pair.kind, pair_points(from, pair), pair_points(to, pair)));
  return share;
}

void SelfContact::add(const Eigen::VectorXd& x, const LoadOutput& output, double) const {
  for (const ContactPair& pair : pairs_.list()) {
    const FourPoints points = pair_points(x, pair);
    const PairDistance near = pair_distance(pair.kind, points);
    const double d = near.distance_m, h = thickness_m_;
    if (d >= h) continue;
    if (d <= 0.0) {
      if (output.energy) *output.energy = std::numeric_limits<double>::infinity();
      return;
    }
    EdgeCross cross;
    Fade m;
    if (pair.kind == PairKind::two_edges) {
      cross = edge_cross(points);
      m = fade(cross.squared_m4, pair.squares_m4);
    }
    const double off = d - h, log = std::log(d / h);
    const double barrier = -stiffness_N_m_ * off * off * log;
    const double slope = stiffness_N_m_ * (-2.0 * off * log - off * off / d);
    const double curvature = stiffness_N_m_ * (-2.0 * log - 4.0 * off / d + off * off / (d * d));
    if (output.energy) *output.energy += m.value * barrier;
    if (output.energy_size) *output.energy_size += m.value * barrier;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      const double weight = near.weight[column];
      const auto node = static_cast<std::size_t>(pair.nodes[c]);
      if (output.gradient) {
        Eigen::Map<Eigen::Vector3d> force(output.gradient + 3 * node);
        force += m.value * slope * weight * near.normal;
        if (m.slope > 0.0) force += m.slope * barrier * cross.slope.col(column);
      }
      if (!output.stiffness) continue;
      // the sum of all |w| is 2
      Eigen::Map<Eigen::Matrix3d> block(
          output.stiffness->block(output.stiffness->column_start()[node]));
      block += m.value * 2.0 * std::abs(weight) * curvature * near.normal * near.normal.transpose();
      if (m.slope > 0.0) block += m.slope * barrier * turn_stiffness(points, column);
    }
  }
}

double SelfContact::nearest_m(const Eigen::VectorXd& x) {
  begin(x);
  double nearest = thickness_m_;
  for (const ContactPair& pair : pairs_.list())
    nearest = std::min(nearest, pair_distance(pair.kind, pair_points(x, pair)).distance_m);
  return nearest;
}

}  // namespace tenter::mechanics
