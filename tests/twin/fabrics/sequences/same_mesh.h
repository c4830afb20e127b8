// SPDX-License-Identifier: GPL-3.0-or-later
// Twins with the fit's own discretisation: what a model on a grid does in a protocol, measured
// without noise. For bands, coverage and exact recovery.
//
// The minimiser is another than the fit's (additive LM, thesis 3.4.1) and the tolerance tighter;
// where it does not get there Newton's method finishes, and `finished_by_newton` says in how many
// frames.
//
// Every frame starts where the sheet truly is: the measured configuration of thesis 3.4.1. (From
// another start a fit may stay on another buckled shape: the frame of #18 then ends at 50 times the
// noise floor.)
//
//   auto twin = same_mesh_twin(fabric, protocol, {.nodes = 13});
//   Random random(stream_seed(seed, "rig"));
//   add_rig_noise({}, random, twin->sequence);
//
// Deterministic, one thread. Error: no equilibrium in a frame, or a model that does not fit.
#pragma once

#include "tests/twin/fabrics/sequences/fabric_model.h"
#include "tests/twin/fabrics/sequences/sequence_of.h"

namespace tenter::twin {

struct MeasuredTwin {
  estimation::Sequence sequence;           ///< with measured values
  std::vector<mechanics::State> states;    ///< of each frame
  std::vector<Eigen::VectorXd> by_node_N;  ///< gradient of the potential, reactions at clips
  int finished_by_newton = 0;
};

/// With fabric_model(fabric).
Expected<MeasuredTwin> same_mesh_twin(const Fabric& fabric, const Protocol& protocol,
                                      const GridOptions& options = {});
/// With any model: its own parameters are the truth.
Expected<MeasuredTwin> measure_model(const model::Model& model, estimation::Sequence sequence);

}  // namespace tenter::twin
