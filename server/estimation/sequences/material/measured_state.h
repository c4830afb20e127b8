// SPDX-License-Identifier: GPL-3.0-or-later
// Where all nodes of a mesh are in a measured frame: what was seen, carried to the nodes, and the
// rest filled in smoothly. A fit starts its frames from there (thesis 3.4.1), and the equation gap
// is taken there.
//
// With x = affine(u, v) + d, coordinate by coordinate:
//
//   min over d   sum over edges (d_i - d_j)^2  +  trust sum over points (B d - (p - affine))^2
//
// nodes that are held keep their places; the affine map is that of least squares through points and
// held nodes. So a stretched or turned sheet is met exactly, and points weigh `trust` times an
// edge.
//
//   MeasuredStates fill(mesh, locations);              // of the points in the mesh
//   fill.at(fixed, x, points_m);                       // x: 3 a node; fixed ones are given in it
//
// One sparse factor for each pattern of held nodes and seen points (625 nodes: a few ms), kept
// while the pattern stays. One thread at a time.
#pragma once

#include <Eigen/SparseCholesky>
#include <utility>
#include <vector>

#include "server/estimation/sequences/material_location.h"

namespace tenter::estimation {

class MeasuredStates {
 public:
  /// The mesh must outlive this.
  MeasuredStates(const mechanics::SurfaceMesh& mesh, std::vector<MaterialLocation> points);

  /// `is_fixed`: one a node. `points_m`: one column a point, NaN where a coordinate was not seen.
  void at(const std::vector<bool>& is_fixed, const Eigen::Matrix3Xd& points_m, Eigen::VectorXd& x);

 private:
  /// A coordinate of space over the material: map . (u, v, 1).
  struct Affine {
    Eigen::Vector3d map = Eigen::Vector3d::Zero();
    double operator()(const Eigen::Vector2d& material_m) const;
  };
  Affine affine(const std::vector<bool>& is_fixed, const Eigen::Matrix3Xd& points_m,
                const Eigen::VectorXd& x, Eigen::Index c) const;
  Eigen::Vector2d place(const MaterialLocation& at) const;
  void fill(const std::vector<bool>& is_fixed, const Eigen::Matrix3Xd& points_m, Eigen::Index c,
            Eigen::VectorXd& x);
  void factorise(const std::vector<bool>& is_fixed, const std::vector<bool>& is_seen);

  static constexpr double kTrust = 100.0;
  const mechanics::SurfaceMesh& mesh_;
  std::vector<MaterialLocation> points_;
  std::vector<std::pair<int, int>> edges_;
  std::vector<bool> fixed_, seen_;  ///< of the factor
  bool has_factor_ = false;
  std::vector<int> unknown_;  ///< of each node; -1: fixed
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace tenter::estimation
