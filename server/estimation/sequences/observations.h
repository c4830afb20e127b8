// SPDX-License-Identifier: GPL-3.0-or-later
// What a model in equilibrium shows on the channels of a sequence, and how that changes with the
// state: m and dm/dx, dm/dG of thesis (4.10), where G = dPi/dx over all nodes (N).
//
//   dm/dp = sum by_x . dx/dp + sum by_gradient . dG/dp
//
// Channels are numbered: x, y and z of each point, then forces, then scalars, each in the order of
// the sequence. A new kind of observation is its type in sequence.h and one overload of `observe`
// and of `check_channel` in observations.cpp.
//
//   const Observations channels(sequence);                   // which has passed check()
//   Observation seen;
//   for (int c = 0; c < channels.count(); ++c) {
//     channels.observe(sequence, c, {boundary, state, by_node}, seen);
//     seen.value ...
//
// Immutable, callable from any thread; nothing allocates once `seen` has seen the largest channel.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/sequences/material_location.h"
#include "server/estimation/sequences/sequence.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::estimation {

/// An equilibrium: `by_node` is dPi/dx there.
struct RestState {
  const mechanics::Boundary& boundary;
  const mechanics::State& state;
  const Eigen::VectorXd& by_node;
};

struct Observation {
  struct ByNode {
    int node = 0;
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
  };
  double value = 0.0;
  std::vector<ByNode> by_x;
  std::vector<ByNode> by_gradient;
};

/// What (3.6) of the thesis tells apart.
enum class ObservationKind { position, force, other };

/// bad_input names the channel: see check(Sequence).
Expected<void> check_channels(const Sequence& sequence);

class Observations {
 public:
  explicit Observations(const Sequence& sequence);

  int count() const { return count_; }
  ObservationKind kind(const Sequence& sequence, int channel) const;
  double sigma(const Sequence& sequence, int channel) const;
  /// NaN where a frame did not see it.
  double measured(const SequenceFrame& frame, int channel) const;

  void observe(const Sequence& sequence, int channel, const RestState& at, Observation& seen) const;

 private:
  int first_force_ = 0;
  int first_scalar_ = 0;
  int count_ = 0;
  std::vector<MaterialLocation> points_;
  std::vector<std::pair<MaterialLocation, MaterialLocation>> lengths_;  ///< [scalar]
};

/// dm/dp from the derivatives of an observation.
void change_of(const Observation& seen, const mechanics::Sensitivity& by_parameter,
               Eigen::RowVectorXd& change);

}  // namespace tenter::estimation
