// SPDX-License-Identifier: GPL-3.0-or-later
// Frictionless contact of nodes with rigid obstacles, as an augmented Lagrangian.
//
//   g(x) >= 0     plane: n . (x - point)      cylinder: distance from its axis - radius
//                 sphere: distance from its middle - radius
//   E += sum over nodes and obstacles  (max(0, lambda - mu g)^2 - lambda^2) / (2 mu)
//
// lambda >= 0 is the force between node and obstacle (N); after a minimisation it is set to
// max(0, lambda - mu g), and the next one starts from there, until no node is deeper than asked.
//
//   Contact contact({Plane{...}}, nodes, mu);
//   contact.add(x, output);                     // in the minimisation
//   contact.update_forces(x);                   // after it
//
// A value; const members are callable from any thread; adding allocates nothing.
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/conditions/loads.h"

namespace tenter::mechanics {

/// Nodes stay on the side that the normal points to.
struct Plane {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit
};

/// Endless; nodes stay outside.
struct Cylinder {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< on the axis
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();    ///< unit
  double radius_m = 0.0;
};

/// Nodes stay outside.
struct Sphere {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< its middle
  double radius_m = 0.0;
};

using Obstacle = std::variant<Plane, Cylinder, Sphere>;

/// bad_input for directions that are not of unit length and a radius that is not positive.
Expected<void> check(const std::vector<Obstacle>& obstacles);

struct Gap {
  double value_m = 0.0;  ///< negative inside the obstacle
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();  ///< d2g/dx2, 1/m
};
/// On the axis of a cylinder or the middle of a sphere the normal is any one.
Gap gap(const Obstacle& obstacle, const Eigen::Vector3d& x);

class Contact {
 public:
  Contact() = default;
  /// `penalty_N_m`: mu > 0.
  Contact(std::vector<Obstacle> obstacles, std::vector<int> nodes, double penalty_N_m);

  bool is_empty() const { return force_N_.size() == 0; }
  /// `positive_share`: how much of the stiffness that is never positive is left out, 0 to 1.
  void add(const Eigen::VectorXd& x, const LoadOutput& output, double positive_share) const;
  /// How deep the deepest node is (m), and how far a node is away that is still pressed: zero when
  /// the conditions of contact are met.
  double violation_m(const Eigen::VectorXd& x) const;
  void update_forces(const Eigen::VectorXd& x);
  /// What the obstacles press with at x, in the order of force_N: max(0, lambda - mu g).
  Eigen::VectorXd acting_forces_N(const Eigen::VectorXd& x) const;
  /// Nodes that are pressed at x, with the direction in which they cannot give way.
  struct Touch {
    int node = 0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  };
  std::vector<Touch> touches(const Eigen::VectorXd& x) const;
  /// The same obstacles elsewhere; forces stay.
  void place(const std::vector<Obstacle>& obstacles) { obstacles_ = obstacles; }
  void set_penalty(double penalty_N_m) { penalty_N_m_ = penalty_N_m; }
  void raise_penalty(double factor) { penalty_N_m_ *= factor; }
  /// lambda; [obstacle * nodes + node].
  const Eigen::VectorXd& force_N() const { return force_N_; }

 private:
  std::vector<Obstacle> obstacles_;
  std::vector<int> nodes_;
  double penalty_N_m_ = 0.0;
  Eigen::VectorXd force_N_;
};

}  // namespace tenter::mechanics
