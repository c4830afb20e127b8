// SPDX-License-Identifier: GPL-3.0-or-later
// A model bound to a cloth or a solid: energy, forces, stiffness, and how the forces change with
// every parameter.
//
//   E(x, p) = sum over terms, over the elements of the term's measure   m w psi(eps(x), p)
//
// m: area or volume of the element, w: weight of the term's support there, psi: energy per area
// (N/m) or volume (N/m^2) of the law. Tetrahedra have one quadrature point, hexahedra eight (thesis
// 4.2.6), and each counts as an element. psi of a path-dependent law is its incremental potential
// in a step from a History (history/); without one it answers as never strained before. Terms on
// the same elements are summed before nodes are touched: elements/ turns the sum into forces and 3
// x 3 blocks once.
//
//   auto model = MeshModel::make(description, cloth);
//   NodeMatrix matrix = model->matrix();
//   status = model->evaluate(x, parameters, {&energy, &gradient, &matrix});
//
// Positions x: 3 numbers a node (m), in the order of the mesh. Outputs are over all nodes: at a
// node that is held, the gradient is the reaction. Exact; O(elements x terms). Immutable: callable
// from any thread; nothing allocates once the outputs have their sizes.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/assembly/cloth.h"
#include "server/mechanics/assembly/energy_limit.h"
#include "server/mechanics/assembly/history/history.h"
#include "server/mechanics/assembly/term_strains.h"
#include "server/mechanics/elements/node_matrix.h"
#include "server/mechanics/mesh/solid_mesh.h"

namespace tenter::mechanics {

enum class AssemblyStatus {
  ok,
  inverted,   ///< a solid element is flat or turned inside out (det F <= kCollapsedStretch), which
              ///< its strains, functions of F'F, do not show; outputs are not to be used, and a
              ///< line search takes the step for one of infinite energy
  not_finite  ///< an element has collapsed (an edge or a triangle's height of zero length) or a law
              ///< left the range of numbers; outputs are not to be used
};

/// Null: not wanted. All are overwritten.
struct ModelOutput {
  double* energy = nullptr;             ///< J
  Eigen::VectorXd* gradient = nullptr;  ///< dE/dx, N: minus the internal force
  NodeMatrix* stiffness = nullptr;      ///< d2E/dx2, N/m; from matrix()
  /// From 0 (exact) to 1: how much of the elements' negative stiffness is left out
  /// (positive_part.h).
  double positive_share = 0.0;
};

/// Values of the parameters of all terms, in the order in which MeshModel takes them.
Eigen::VectorXd term_parameters(const model::Model& model);

class MeshModel {
 public:
  /// bad_input names the term or the limit: a solid's strain, an unknown name, an rbf support
  /// without two coordinates, a measure of which this cloth has no element, or a limit on terms of
  /// different elements.
  static Expected<MeshModel> make(const model::Model& model, const Cloth& cloth);
  /// The same for a mesh of tetrahedra, hexahedra or both: every term acts on all of them.
  /// bad_input: a strain of cloth, an unknown name, an rbf support without three coordinates, or a
  /// mesh that does not pass check().
  static Expected<MeshModel> make(const model::Model& model, const SolidMesh& mesh);

  int node_count() const { return node_count_; }
  int parameter_count() const { return parameter_count_; }
  /// Zero, with the pattern of the stiffness.
  NodeMatrix matrix() const { return matrix_; }

  /// With `limits`, the model's energy limits add their part to all outputs (energy_limit.h; their
  /// multipliers have the size limited_count()); without, they are not enforced.
  [[nodiscard]] AssemblyStatus evaluate(const Eigen::VectorXd& x, const Eigen::VectorXd& parameters,
                                        const ModelOutput& output,
                                        const EnergyLimitState* limits = nullptr,
                                        const History* history = nullptr) const;

  /// d2E/dx dp: (3 nodes) x parameters, column by column. With `limits`, also of their part
  /// m/(2 mu) (a^2 - l^2) at fixed multipliers: m (a d2psi/dx dp + mu dpsi/dx dpsi/dp). At fixed
  /// `history`: what it changes is added by add_gradient_by_history.
  [[nodiscard]] AssemblyStatus gradient_by_parameter(const Eigen::VectorXd& x,
                                                     const Eigen::VectorXd& parameters,
                                                     Eigen::MatrixXd& result,
                                                     const EnergyLimitState* limits = nullptr,
                                                     const History* history = nullptr) const;

  /// Numbers in a History's state; 0 where no law remembers anything.
  int history_count() const { return history_count_; }
  /// Whether a law's tangent jumps where a strain turns round (law.h).
  bool turns_round() const { return turns_round_; }
  History never_strained() const { return {Eigen::VectorXd::Zero(history_count_), 0.0}; }
  /// The state at the end of the step from `history` to x; may be that of `history` itself.
  [[nodiscard]] AssemblyStatus end_of_step(const Eigen::VectorXd& x,
                                           const Eigen::VectorXd& parameters,
                                           const History& history, Eigen::VectorXd& state) const;
  /// result += d2E/dx dh change, column by column: `change` is dh (history_count() rows).
  [[nodiscard]] AssemblyStatus add_gradient_by_history(const Eigen::VectorXd& x,
                                                       const Eigen::VectorXd& parameters,
                                                       const History& history,
                                                       const Eigen::MatrixXd& change,
                                                       Eigen::MatrixXd& result) const;
  /// From dh at the start of the step to dh at its end, in place: `x_change` is dx, and column c is
  /// of the parameter columns[c], or of none where that is negative.
  [[nodiscard]] AssemblyStatus carry_history_change(const Eigen::VectorXd& x,
                                                    const Eigen::VectorXd& parameters,
                                                    const History& history,
                                                    const Eigen::MatrixXd& x_change,
                                                    const std::vector<Eigen::Index>& columns,
                                                    Eigen::MatrixXd& change) const;

  int term_count() const { return term_count_; }
  /// The part of the energy (J) of each term, in the order of the model's terms: of a term that
  /// remembers its path, of the step from `history`, up to a constant.
  [[nodiscard]] AssemblyStatus term_energies(const Eigen::VectorXd& x,
                                             const Eigen::VectorXd& parameters,
                                             Eigen::VectorXd& energies,
                                             const History* history = nullptr) const;
  /// One entry for each term and kind of element that it acts on, in the order of the terms.
  [[nodiscard]] AssemblyStatus term_strains(const Eigen::VectorXd& x,
                                            std::vector<TermStrains>& strains) const;

  /// Elements under the description's energy limits: none where it has none.
  int limited_count() const { return limited_count_; }
  const std::vector<LimitedElements>& limited() const { return limited_; }
  /// psi - psi_max (J/m^2 or J/m^3) of each: above zero where a limit is violated.
  [[nodiscard]] AssemblyStatus limit_excess(const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& parameters,
                                            Eigen::VectorXd& excess) const;

  /// The limits that are active at x and their derivatives. dpsi/dp is exact to rounding where the
  /// density is a polynomial of up to the fourth degree in a parameter, as most laws are of the
  /// first; to about 1e-11 of it otherwise.
  [[nodiscard]] AssemblyStatus active_limits(const Eigen::VectorXd& x,
                                             const Eigen::VectorXd& parameters,
                                             const EnergyLimitState& limits,
                                             ActiveLimits& active) const;

  class Group;    ///< elements of one kind, and the terms on them (group.h)
  class Builder;  ///< what the two makers have in common (model_builder.h)

 private:
  int node_count_ = 0;
  int parameter_count_ = 0;
  int term_count_ = 0;
  int history_count_ = 0;
  int limited_count_ = 0;
  bool turns_round_ = false;
  std::vector<LimitedElements> limited_;
  NodeMatrix matrix_;
  std::vector<std::shared_ptr<const Group>> groups_;
};

}  // namespace tenter::mechanics
