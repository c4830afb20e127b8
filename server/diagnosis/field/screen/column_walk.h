// SPDX-License-Identifier: GPL-3.0-or-later
// One sequence of a fit, frame after frame, with the columns of what is added: for added_columns.h
// alone.
#pragma once

#include <optional>
#include <vector>

#include "server/diagnosis/field/screen/added_columns.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sensors/sequence_sensors.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::diagnosis {

/// Terms that share a mesh: all that are elastic together; each that remembers by itself, so that
/// what its history owes to parameters stays small.
struct TermGroup {
  model::Model model;
  std::vector<Eigen::Index> own;      ///< its parameters that are wanted
  std::vector<Eigen::Index> columns;  ///< where they go among the wanted
  bool remembers = false;
};

std::vector<TermGroup> grouped(const Added& added);

/// What all sequences share. References of the caller's.
struct ColumnTask {
  const FieldFit& fit;
  const FieldData& data;
  const Added& added;
  const std::vector<TermGroup>& groups;
  const estimation::SequenceSensors& own_sensors;  ///< of the fitted model
  const estimation::SequenceSensors& all_sensors;  ///< and with what is added
  Eigen::VectorXd parameters;                      ///< of both, as all_sensors has them
};

class ColumnWalk {
 public:
  ColumnWalk(const ColumnTask& task, std::size_t sequence);

  /// Writes the rows of its sequence: row_of[frame][channel], -1 where there is none.
  Expected<void> run(const std::vector<std::vector<int>>& row_of, estimation::RowMatrix& result);

 private:
  struct Part {  ///< a group on the sequence's mesh
    const TermGroup& group;
    mechanics::MeshModel mesh;
    Eigen::VectorXd values;
    mechanics::History history = {};  ///< of terms that remember
    Eigen::MatrixXd change = {};
  };

  Expected<void> set_up();
  Expected<mechanics::EquilibriumResult> come_to_rest(std::size_t f,
                                                      mechanics::EquilibriumSolver& solver,
                                                      mechanics::State& state);
  Expected<void> frame(std::size_t f, const std::vector<int>& row_of,
                       estimation::RowMatrix& result);
  Expected<void> pull(Part& part, const mechanics::State& state, double duration_s,
                      Eigen::MatrixXd& partial);
  Expected<mechanics::Sensitivity> by_terms(std::size_t f, mechanics::EquilibriumSolver& solver,
                                            const mechanics::State& state);
  Expected<void> by_rig(std::size_t f, mechanics::EquilibriumSolver& solver,
                        const mechanics::State& state, mechanics::Sensitivity& moved,
                        std::vector<Eigen::Index>& felt);
  void show_terms(const std::vector<std::vector<int>>& row_of, estimation::RowMatrix& result);
  void show_corrections(const std::vector<std::vector<int>>& row_of, estimation::RowMatrix& result);

  const ColumnTask& task_;
  std::size_t index_;
  const estimation::Sequence& sequence_;
  const estimation::Observations channels_;
  Eigen::Index terms_, corrections_;  ///< columns
  /// Parameters of corrections that are wanted, as all_sensors_ counts them, and those of them that
  /// move the equilibrium.
  std::vector<Eigen::Index> wanted_, rig_;
  std::vector<Part> parts_;
  std::optional<mechanics::MeshModel> base_;
  std::vector<std::optional<mechanics::EquilibriumSolver>> solvers_;
  Eigen::VectorXd term_parameters_;
  bool remembers_ = false;  ///< the fitted model
  mechanics::History history_;
  Eigen::MatrixXd change_, rig_change_;
  /// Where instruments stand between: what the frames show, and by the columns, before them.
  std::vector<estimation::Readings> own_, all_;
  std::vector<estimation::RowMatrix> raw_;
};

}  // namespace tenter::diagnosis
