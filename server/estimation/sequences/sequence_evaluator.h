// SPDX-License-Identifier: GPL-3.0-or-later
// Residuals of a model against measured sequences, by output error (thesis (3.6)): every frame is
// brought to equilibrium with the model's parameters, and what it predicts is compared.
//
//   r = (predicted - measured) / sigma
//   Jacobian by the implicit function theorem (thesis (3.7), (3.8)), with equilibrium's own factor
//
// The first evaluation walks every sequence from its start. Later ones start each frame from where
// the last Jacobian was taken, moved by dx/dp times the change of the parameters; so frames are
// independent of each other and are solved in as many threads as wanted, with the same bytes.
//
//   auto evaluator = SequenceEvaluator::make(model, sequences, {.threads = 2});
//   FitResult result = fit(*evaluator, model, options);
#pragma once

#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/sequence.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation {

struct SequenceOptions {
  int threads = 1;
  double tolerance_N = 1e-8;  ///< of the net force: below what differences of residuals show
};

class SequenceEvaluator final : public ResidualFunction {
 public:
  /// bad_input as check(Sequence), MeshModel::make and EquilibriumSolver::make, with the name of
  /// the sequence; also for a model with sensor corrections, which sequences do not have yet.
  static Expected<SequenceEvaluator> make(const model::Model& model,
                                          std::vector<Sequence> sequences,
                                          const SequenceOptions& options = {});

  int parameter_count() const override { return parameter_count_; }
  const std::vector<Row>& rows() const override { return rows_; }
  /// no_equilibrium where a frame finds no stable rest.
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;

  const std::vector<Sequence>& sequences() const { return sequences_; }
  /// Of the last evaluation that ended ok, [sequence][frame].
  const std::vector<std::vector<mechanics::State>>& states() const { return states_; }
  /// Why the last evaluation failed; empty if it did not.
  const std::string& failure() const { return failure_; }

 private:
  struct Bound;      ///< a sequence with its model and locations
  struct FrameWork;  ///< what is kept of a frame

  SequenceEvaluator() = default;
  /// Made when first wanted: a thread's own for each boundary of each sequence.
  mechanics::EquilibriumSolver& solver_of(int thread, std::size_t sequence, std::size_t frame);
  bool walk(std::size_t sequence, int thread, const Eigen::VectorXd& parameters);
  bool solve_frame(std::size_t sequence, std::size_t frame, mechanics::EquilibriumSolver& solver,
                   const Eigen::VectorXd& parameters, bool is_near, bool wants_sensitivity);
  void write_rows(std::size_t sequence, std::size_t frame, Eigen::VectorXd& residuals,
                  RowMatrix* jacobian) const;

  SequenceOptions options_;
  std::vector<Sequence> sequences_;
  std::vector<std::shared_ptr<const Bound>> bound_;
  std::vector<std::vector<std::shared_ptr<FrameWork>>> frames_;
  /// [thread][sequence][boundary]
  std::vector<std::vector<std::vector<std::unique_ptr<mechanics::EquilibriumSolver>>>> solvers_;
  std::vector<Row> rows_;
  std::vector<std::vector<mechanics::State>> states_;
  std::string failure_;
  int parameter_count_ = 0;
  bool has_base_ = false;
  Eigen::VectorXd base_parameters_;
};

}  // namespace tenter::estimation
