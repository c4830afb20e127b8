// SPDX-License-Identifier: GPL-3.0-or-later
// The shape in which a strip of the model hangs from its clamp, and how it moves with every
// parameter.
//
//   T(eps_i) = -rho g integral_s^L (L - t) cos theta(t) dt       (thesis 5.7, with eps = 3 theta')
//
// Even cells of one curvature each; unknown are the directions theta at their borders. What T holds
// is the slope of bending's work by an angle, gravity's that of rho g int (L - t) sin theta: so the
// equations are those of a chain, tridiagonal, and Newton's way goes down the work.
//
// Pieces of which the law says nothing (held runs: they did not go one way) keep the strains that
// were read, and turn besides by angles at a few even places, as far as what was read is uncertain:
// those angles, and place and direction of the clamp, are the `placement`
//
//   x, y, theta of the clamp; then the turns of each held run
//
// which the caller fits to what was seen. Cost: about 8 evaluations of T a cell. One thread per
// object; the result depends on nothing but the arguments.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/friction_tests/bending/contour/one_way.h"
#include "server/estimation/friction_tests/bending/profile_curve.h"

namespace tenter::estimation {

/// Cells first to last - 1; turns: not more than there are cells.
struct HeldRun {
  int first = 0;
  int last = 0;
  int turns = 1;
  /// The cell at whose end the strip turns.
  int turn_at(int turn) const { return first + (2 * turn + 1) * (last - first) / (2 * turns); }
};

class RestingShape {
 public:
  /// `strain`: what was read, one a cell; only that of held runs counts.
  RestingShape(double length_m, double weight_N_m2, Eigen::VectorXd strain,
               std::vector<HeldRun> held);

  int cells() const { return cells_; }
  int placement_count() const { return placement_count_; }
  const std::vector<HeldRun>& held() const { return held_; }

  /// From a guess of the directions (cells + 1); false where no rest is found.
  [[nodiscard]] bool rest(OneWay& way, const Eigen::VectorXd& placement,
                          const Eigen::VectorXd& guess);
  const Eigen::VectorXd& directions() const { return directions_; }
  /// Cells past a snap, or on one.
  int snapped() const { return snapped_; }
  /// After rest(): fills what place() says of derivatives, by parameters and then by placement.
  void differentiate(OneWay& way, int parameters);

  struct Place {
    double x = 0.0, y = 0.0, direction = 0.0;
  };
  Place place(double arc_m) const;
  /// Rows x, y and direction at `arc_m`; columns parameters, then placement.
  void place_by(double arc_m, Eigen::Matrix<double, 3, Eigen::Dynamic>& by) const;

 private:
  void turn();
  double torque_at(int cell) const;
  double meet(OneWay& way);
  void touch(OneWay& way);
  bool is_small(double torque) const;
  bool leap(OneWay& way);
  bool creep(OneWay& way, int steps, double& held_back);
  bool creep_and_leap(OneWay& way);
  void assemble(double held_back);
  bool factorise();
  void solve(Eigen::VectorXd& x) const;
  void lay_out();
  Place within(int cell, double way) const;
  int cell_of(double arc_m) const;

  double length_, cell_, weight_;
  int cells_;
  Eigen::VectorXd strain_;
  std::vector<HeldRun> held_;
  /// Of each border: its unknown (-1: tied to the clamp), and by how much it turns beyond that.
  std::vector<int> unknown_;
  Eigen::VectorXd turned_;
  std::vector<bool> is_held_;
  int count_ = 0;
  int placement_count_ = 3;

  Eigen::VectorXd placement_, unknowns_, directions_;
  /// Of cells: the line that stands for the law, torque_ at strain_at_ with slope tangent_.
  Eigen::VectorXd strain_at_, torque_, tangent_, law_at_;
  Eigen::VectorXd force_;              ///< of borders: slope of the work
  Eigen::VectorXd diagonal_, beside_;  ///< of borders: tridiagonal second derivatives
  Eigen::VectorXd reduced_, matrix_diagonal_, matrix_beside_;  ///< of unknowns
  Eigen::VectorXd pivot_, lower_;
  int snapped_ = 0;
  Eigen::VectorXd x_, y_;                        ///< at borders
  Eigen::MatrixXd directions_by_, x_by_, y_by_;  ///< borders x columns
  int parameters_ = 0;
};

}  // namespace tenter::estimation
