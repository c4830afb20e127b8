// SPDX-License-Identifier: GPL-3.0-or-later
// Residuals of a model against measured sequences, by output error (thesis (3.6)): every frame is
// brought to equilibrium with the model's parameters, and what it predicts is compared.
//
//   r = (predicted - measured) / sigma
//   Jacobian by the implicit function theorem (thesis (3.7), (3.8), (4.10)), with equilibrium's own
//   factor
//
// The first evaluation walks every sequence from its start, or from the measured configurations of
// its frames. Later ones start each frame from where the last Jacobian was taken, moved by dx/dp
// times the change of the parameters; so frames are independent of each other and are solved in as
// many threads as wanted, with the same bytes. A model whose laws remember their path (friction,
// plastic slip) is walked frame by frame from a sheet that was never strained, every time, and its
// Jacobian is that of the whole path; then sequences are independent of each other, so that
// elasticity and friction are fitted together. While a fit is stepping (Accuracy::stepping) a frame
// costs about one factorisation, which serves the sensitivities too.
//
// A model's sensor corrections (sensors/sequence_sensors.h) come last among the parameters: what is
// compared is what the instruments would have shown.
//
//   auto evaluator = SequenceEvaluator::make(model, sequences, {.threads = 2});
//   FitResult result = fit(*evaluator, model, options);
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/sensors/sequence_sensors.h"
#include "server/estimation/sequences/sequence.h"
#include "server/estimation/sequences/weighting.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation {

/// A frame that is about to be solved. Refers to what lives as long as the call.
struct FrameNote {
  const Sequence& sequence;
  int frame = 0;  ///< from 0
  const Eigen::VectorXd& parameters;
};

struct SequenceOptions {
  int threads = 1;
  double tolerance_N = 1e-8;  ///< of the net force: below what differences of residuals show
  /// The same while a fit is stepping, where larger. Steps with a factor that is there cost little:
  /// 1e-6 N saves a twentieth of a fit, and ends a tenth of a standard error beside its optimum.
  double stepping_tolerance_N = 1e-8;
  /// Of Newton, for a frame that starts from its prediction while a fit is stepping. What needs
  /// more of them is no longer where the sensitivities said: a shorter step costs less than its
  /// rest.
  int stepping_max_iterations = 40;
  /// The frames' starts are rests of nearly these parameters: few iterations, and no positive share
  /// of the stiffness to begin with.
  bool starts_are_near = false;
  Weighting weighting = {};
  /// Jacobians by these parameters alone, the other columns zero; empty: by all. Those of a stage
  /// that holds most of a model cost a fraction.
  std::vector<Eigen::Index> moving = {};
  std::function<double()> clock =
      nullptr;  ///< in seconds, for SequenceCost; callable from any thread
  /// For whoever watches; called from any thread, returns soon.
  std::function<void(const FrameNote&)> on_frame = nullptr;
};

/// What evaluations have cost so far. Seconds are summed over threads; zero without a clock. Of an
/// evaluation that fails, threads may have solved more or fewer of the frames after the first that
/// has no rest.
struct SequenceCost {
  int equilibria = 0;
  int iterations = 0;
  int factorisations = 0;
  int evaluations = 0;  ///< of a mesh's energy, with or without derivatives
  int sensitivities = 0;
  double equilibrium_s = 0.0;
  double sensitivity_s = 0.0;
};

class SequenceEvaluator final : public ResidualFunction {
 public:
  /// bad_input as check(Sequence), MeshModel::make and EquilibriumSolver::make, with the name of
  /// the sequence, and as SequenceSensors::make.
  static Expected<SequenceEvaluator> make(const model::Model& model,
                                          std::vector<Sequence> sequences,
                                          const SequenceOptions& options = {});

  int parameter_count() const override { return parameter_count_; }
  const std::vector<Row>& rows() const override { return rows_; }
  /// no_equilibrium where a frame finds no stable rest.
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  /// The cost, sum of weight r^2, and its gradient by the adjoint: one solve a frame however many
  /// parameters there are (of a model that remembers or has sensor corrections: by its Jacobian).
  /// For many of them; fit() uses the Jacobian.
  [[nodiscard]] mechanics::PathStatus evaluate_gradient(const Eigen::VectorXd& parameters,
                                                        double& cost, Eigen::VectorXd& gradient);
  void set_accuracy(Accuracy accuracy) override { accuracy_ = accuracy; }
  Eigen::VectorXd weights() const override { return weights_; }

  const std::vector<Sequence>& sequences() const { return sequences_; }
  /// Of the last evaluation that ended ok, [sequence][frame].
  const std::vector<std::vector<mechanics::State>>& states() const { return states_; }
  /// Why the last evaluation failed; empty if it did not.
  const std::string& failure() const { return failure_; }
  const SequenceCost& cost() const { return cost_; }

 private:
  struct Bound;      ///< a sequence with its model and channels
  struct FrameWork;  ///< what is kept of a frame
  struct Run {       ///< frames that are walked one after the other
    std::size_t sequence = 0, first = 0, last = 0;
  };
  enum class Derivative { none, by_parameter, of_cost };
  struct SolveHow {
    bool is_near = false;
    bool may_predict = false;  ///< from the solve before: only where one thread walks
    Derivative wanted = Derivative::none;
    const mechanics::History* history = nullptr;
    bool gives_up = false;  ///< after stepping_max_iterations
  };

  SequenceEvaluator() = default;
  /// Made when first wanted: a thread's own for each boundary of each sequence.
  mechanics::EquilibriumSolver& solver_of(int thread, std::size_t sequence, std::size_t frame);
  bool solve_all(const Eigen::VectorXd& parameters, Derivative wanted);
  void walk(const Run& run, int thread, const Eigen::VectorXd& parameters, Derivative wanted);
  void walk_remembering(std::size_t sequence, int from, int thread,
                        const Eigen::VectorXd& parameters, Derivative wanted);
  void start_from(const FrameWork& work, int from, const std::vector<Eigen::Index>& columns,
                  const Eigen::VectorXd& parameters, mechanics::State& state) const;
  bool solve_frame(std::size_t sequence, std::size_t frame, int thread,
                   const Eigen::VectorXd& parameters, const SolveHow& how);
  Expected<void> differentiate(std::size_t sequence, std::size_t frame,
                               mechanics::EquilibriumSolver& solver,
                               const Eigen::VectorXd& parameters, Derivative wanted);
  bool has_failed();
  template <class Visit>
  void each_row(std::size_t sequence, std::size_t frame, const Visit& visit) const;
  void write_rows(std::size_t sequence, std::size_t frame, Eigen::VectorXd& residuals,
                  RowMatrix* jacobian) const;
  void read_channels(std::size_t sequence, std::size_t frame, bool sensitivities);
  void write_shown(std::size_t sequence, std::size_t frame, const Readings& shown,
                   Eigen::VectorXd& residuals, RowMatrix* jacobian) const;
  void write_as_shown(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals,
                      RowMatrix* jacobian);

  SequenceOptions options_;
  std::vector<Sequence> sequences_;
  SequenceSensors sensors_;
  std::vector<std::vector<Readings>> readings_;  ///< [sequence][frame], as predicted
  std::vector<Readings> shown_;                  ///< [thread]
  Eigen::VectorXd term_parameters_;              ///< of the evaluation that is under way
  std::vector<std::shared_ptr<const Bound>> bound_;
  std::vector<std::vector<std::shared_ptr<FrameWork>>> frames_;
  std::vector<std::pair<std::size_t, std::size_t>> all_frames_;
  std::vector<Run> runs_;
  /// [thread][sequence][boundary]
  std::vector<std::vector<std::vector<std::unique_ptr<mechanics::EquilibriumSolver>>>> solvers_;
  std::vector<Row> rows_;
  Eigen::VectorXd weights_;
  std::vector<std::vector<mechanics::State>> states_;
  std::string failure_;
  SequenceCost cost_;
  int parameter_count_ = 0;
  int term_parameter_count_ = 0;
  bool remembers_ = false;  ///< the model
  Accuracy accuracy_ = Accuracy::exact;

  // every frame keeps two slots: where the last Jacobian was taken, and the last evaluation, which
  // may be the same
  int base_ = -1;  ///< -1: none
  int last_ = -1;
  Eigen::VectorXd base_parameters_, last_parameters_;
  Accuracy last_accuracy_ = Accuracy::exact;
  bool last_has_sensitivity_ = false;
};

}  // namespace tenter::estimation
