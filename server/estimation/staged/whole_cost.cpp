// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/whole_cost.h"

#include <cmath>

#include "server/estimation/parallel.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::estimation {
namespace {

using Value = WholeCost::Value;

/// More would cost as much as the stage itself.
constexpr int kFrames = 6;
constexpr double kShare = 0.01;

struct Means {
  double mine = 0.0, others = 0.0;
  double variance = 0.0;  ///< of `others` where all of it is noise
};

/// Weighted means of squares over the frames that both have.
Means means_of(const Value& mine, const Value& others) {
  Means means;
  for (std::size_t s = 0; s < mine.part.size(); ++s) {
    double a = 0.0, b = 0.0;
    int rows = 0;
    for (std::size_t f = 0; f < mine.part[s].size(); ++f) {
      if (!mine.part[s][f] || !others.part[s][f]) continue;
      a += mine.part[s][f]->squares;
      b += others.part[s][f]->squares;
      rows += mine.part[s][f]->rows;
    }
    if (rows == 0) continue;
    const double weight = mine.weight[s];
    means.mine += weight * a / rows;
    means.others += weight * b / rows;
    means.variance += weight * weight * 2.0 / rows;
  }
  return means;
}

Value::Part part_of(const Sequence& sequence, const Observations& channels, std::size_t frame,
                    const RestState& rest) {
  Value::Part part;
  Observation seen;
  for (int c = 0; c < channels.count(); ++c) {
    const double measured = channels.measured(sequence.frames[frame], c);
    if (std::isnan(measured)) continue;
    channels.observe(sequence, c, rest, seen);
    const double residual = (seen.value - measured) / channels.sigma(sequence, c);
    part.squares += residual * residual;
    ++part.rows;
  }
  return part;
}

}  // namespace

int Value::restless() const {
  int count = 0;
  for (const auto& frames : part)
    for (const auto& frame : frames) count += frame ? 0 : 1;
  return count;
}

double Value::cost(const Value& other) const {
  return means_of(*this, other).mine;
}

bool Value::is_above(const Value& before) const {
  if (restless() != before.restless()) return restless() > before.restless();
  const Means means = means_of(*this, before);
  return means.mine > (1.0 + kShare) * means.others + 2.0 * std::sqrt(means.variance);
}

WholeCost::WholeCost(const model::Model& model, const std::vector<RoleSequence>& measured,
                     const StageOptions& options)
    : threads_(options.threads), tolerance_N_(options.tolerance_N) {
  for (const RoleSequence& s : measured) {
    if (s.role == Role::evaluation) continue;
    sequences_.push_back(observed(s, options.channels));
    keep_frames(sequences_.back(),
                taken_frames(model, static_cast<int>(sequences_.back().frames.size()), kFrames));
  }
}

Expected<Value> WholeCost::of(const model::Model& model) const {
  const Eigen::VectorXd parameters = mechanics::term_parameters(model);
  std::vector<std::optional<Expected<RestingFrames>>> found(sequences_.size());
  in_parallel(threads_, static_cast<int>(found.size()), [&](int, int i) {
    const auto s = static_cast<std::size_t>(i);
    found[s].emplace(resting_frames(model, sequences_[s], parameters, tolerance_N_));
  });
  Value value;
  for (std::size_t s = 0; s < sequences_.size(); ++s) {
    if (!*found[s]) return tl::unexpected(found[s]->error());
    const RestingFrames& at = **found[s];
    const Sequence& sequence = sequences_[s];
    const Observations channels(sequence);
    value.weight.push_back(sequence.weight);
    auto& parts = value.part.emplace_back(sequence.frames.size());
    for (std::size_t k = 0; k < at.resting.size(); ++k) {
      const auto f = static_cast<std::size_t>(at.resting[k]);
      const auto boundary = static_cast<std::size_t>(sequence.frames[f].boundary);
      parts[f] = part_of(sequence, channels, f,
                         {sequence.boundaries[boundary], at.states[k], at.by_node_N[k]});
    }
  }
  return value;
}

}  // namespace tenter::estimation
