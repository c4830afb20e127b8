// SPDX-License-Identifier: GPL-3.0-or-later
// What SequenceEvaluator keeps of sequences and frames. For its two sources alone.
#pragma once

#include <string>
#include <vector>

#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::estimation {

struct SequenceEvaluator::Bound {
  mechanics::MeshModel model;
  Observations channels;
  std::vector<std::vector<int>> row_of;  ///< [frame][channel]; -1: not measured
  /// Flat parameters that move its equilibria and that Jacobians are by: the terms', then the
  /// rig's.
  std::vector<Eigen::Index> columns;
  std::vector<Eigen::Index> terms;  ///< their own part
  std::vector<Eigen::Index> rig;
};

struct SequenceEvaluator::FrameWork {
  struct Slot {
    mechanics::State state;
    mechanics::Sensitivity by_parameter;
    Eigen::VectorXd by_node;      ///< gradient of the potential
    double cost = 0.0;            ///< of the frame's rows, where its gradient was wanted
    Eigen::VectorXd cost_change;  ///< that gradient
    // of models that remember
    mechanics::History start;          ///< of the frame's step
    Eigen::VectorXd end;               ///< the history's state at its end
    Eigen::MatrixXd end_by_parameter;  ///< dH/dp, a column for each of by_parameter
  };
  Slot slots[2];
  SequenceCost cost;  ///< of the evaluation that is under way
  std::string failure;
};

}  // namespace tenter::estimation
