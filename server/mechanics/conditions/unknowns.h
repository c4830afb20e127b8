// SPDX-License-Identifier: GPL-3.0-or-later
// The unknowns of equilibrium: three per free node, six per free clip, nothing for what is held.
//
// A free clip moves by a turn w and a shift v about its point c (the middle of its nodes):
//
//   x_i <- c + v + R(w) r_i       r_i = x_i - c        dx_i = [-[r_i]x  I] (dw, dv)
//
// so everything that is known over all nodes (gradient, NodeMatrix) becomes something over the
// unknowns; the clip's block also gets the second derivative of the turn,
// sum_i (f_i r_i' + r_i f_i')/2 - (f_i . r_i) I.
//
//   const Unknowns unknowns(boundary, model.matrix());
//   unknowns.reduce(gradient, matrix, ...);        // every iteration: O(entries), no search
//   unknowns.move(state, step, 1.0, moved);
//
// Immutable; callable from any thread; nothing allocates after construction.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/conditions/boundary.h"
#include "server/mechanics/conditions/loads.h"
#include "server/mechanics/conditions/node_energy.h"
#include "server/mechanics/elements/node_matrix.h"
#include "server/mechanics/sparse/symmetric_pattern.h"

namespace tenter::mechanics {

class Unknowns {
 public:
  /// `boundary` has passed check(). The pattern comes from `matrix`.
  Unknowns(const Boundary& boundary, const NodeMatrix& matrix);

  int count() const { return pattern_.size; }
  const SymmetricPattern& pattern() const { return pattern_; }
  const std::vector<int>& free_nodes() const { return free_nodes_; }

  /// What a change of the unknowns does to a linear function of the nodes: J' by_node, where
  /// expand() is J.
  void restrict_to(const State& state, const Eigen::VectorXd& by_node,
                   Eigen::VectorXd& by_unknown) const;

  /// Gradient by the unknowns from the one by the nodes; cords and weight of free clips come in
  /// here. N for nodes and shifts, N m for turns.
  void reduce_gradient(const Loads& loads, const State& state, const Eigen::VectorXd& by_node,
                       Eigen::VectorXd& by_unknown) const;

  /// Values of the pattern. `positive_share`: how much of the negative second
  /// derivative of turns is left out, 0 to 1.
  void reduce_matrix(const Loads& loads, const State& state, const Eigen::VectorXd& by_node,
                     const NodeMatrix& matrix, double positive_share,
                     std::vector<double>& values) const;

  /// What a spring of a free clip adds to the gradient, and to the values of the pattern.
  void add_spring_gradient(const ClipSpring& spring, const State& state,
                           Eigen::VectorXd& by_unknown) const;
  void add_spring_stiffness(const ClipSpring& spring, const State& state, double positive_share,
                            std::vector<double>& values) const;

  /// Displacements of all nodes that belong to a displacement of the unknowns.
  void expand(const State& state, const Eigen::VectorXd& by_unknown,
              Eigen::VectorXd& by_node) const;

  /// moved = state after `fraction` of `step`; another object than `state`. Allocates where `moved`
  /// has other sizes.
  void move(const State& state, const Eigen::VectorXd& step, double fraction, State& moved) const;

  /// 2-norm of the net force; torques count as forces at the distance of the clip's nodes.
  double net_force_N(const Eigen::VectorXd& by_unknown) const;
  /// The longest way of a node (m) in a step; a clip's turn counts at the distance of its nodes.
  double longest_move_m(const Eigen::VectorXd& step) const;

 private:
  /// A free clip.
  struct Body {
    int clip = 0;
    int first_unknown = 0;  ///< turn, then shift
    double arm_m = 0.0;     ///< root mean square distance of its nodes from their middle
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();  ///< in the clip's frame
  };
  /// A block of the NodeMatrix between free nodes.
  struct FreeBlock {
    int block = 0;
    bool is_diagonal = false;
    int slots[3] = {};  ///< where each of its columns begins, on the diagonal if it lies there
  };
  /// A block of the NodeMatrix with a body on one side at least.
  struct BodyBlock {
    int block = 0;
    int row_node = 0, column_node = 0;
    int row_body = -1, column_body = -1;
    std::vector<int> slots;  ///< of the product's entries, column by column; -1: none
  };

  Eigen::Vector3d middle(const Body& body, const State& state) const {
    return state.clips[static_cast<std::size_t>(body.clip)].to_space(body.middle_m);
  }
  Eigen::Matrix<double, 3, 6> jacobian(const Body& body, const State& state, int node) const;
  const Body& body_of_clip(int clip) const;

  Boundary boundary_;
  SymmetricPattern pattern_;
  std::vector<int> free_nodes_;
  std::vector<int> first_unknown_;  ///< of each node; -1: not free
  std::vector<Body> bodies_;
  std::vector<FreeBlock> free_blocks_;
  std::vector<BodyBlock> body_blocks_;
};

}  // namespace tenter::mechanics
