// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/next/clip_bench.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/field/next/clip_way.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::diagnosis {
namespace {

constexpr std::size_t kMostMountings = 2;  // each plan is two dozen rests of every rival

/// Of each sequence, chi2 between the two rivals that differ most there, a row.
std::vector<double> apart_so_far(const std::vector<const FieldFit*>& rivals,
                                 const FieldData& data) {
  std::vector<double> most(data.sequences.size(), 0.0);
  for (std::size_t i = 0; i < rivals.size(); ++i)
    for (std::size_t j = i + 1; j < rivals.size(); ++j) {
      std::vector<double> sum(most.size(), 0.0), rows(most.size(), 0.0);
      for (std::size_t r = 0; r < rivals[i]->rows.size(); ++r) {
        const auto s = static_cast<std::size_t>(rivals[i]->rows[r].curve);
        const auto k = static_cast<Eigen::Index>(r);
        sum[s] += std::pow(rivals[i]->at.fit.residuals[k] - rivals[j]->at.fit.residuals[k], 2);
        rows[s] += 1.0;
      }
      for (std::size_t s = 0; s < most.size(); ++s)
        if (rows[s] > 0.0) most[s] = std::max(most[s], sum[s] / rows[s]);
    }
  return most;
}

double largest_force(const FieldData& data) {
  double largest = 0.0;
  for (const estimation::Sequence& sequence : data.sequences)
    for (const estimation::SequenceFrame& frame : sequence.frames)
      for (const double force_N : frame.forces_N)
        if (std::isfinite(force_N)) largest = std::max(largest, std::abs(force_N));
  return largest;
}

}  // namespace

std::optional<Foretold> foretell(const Experiment& plan, const FieldFit& at, const FieldData& data,
                                 int like, int threads) {
  const auto s = static_cast<std::size_t>(like);
  const auto way = way_of(data.sequences[s]);
  if (!way) return std::nullopt;
  FieldData next;
  next.sequences.push_back(sequence_of(plan, data.sequences[s], *way));
  next.sequences.front().frames.front().start = at.states[s].front();
  const model::Model acting = acting_on(at.at.model, next);
  estimation::SequenceOptions how;
  how.threads = threads;
  how.weighting.rule = estimation::WeightingRule::by_noise;
  auto evaluator = estimation::SequenceEvaluator::make(acting, next.sequences, how);
  if (!evaluator) return std::nullopt;
  Foretold result;
  estimation::RowMatrix jacobian;
  if (evaluator->evaluate(estimation::parameter_values(acting), result.whitened, &jacobian) !=
      mechanics::PathStatus::ok)
    return std::nullopt;

  // what does nothing in a new capture has no columns there
  const auto all = estimation::parameter_names(at.at.model);
  const auto here = estimation::parameter_names(acting);
  const std::vector<Eigen::Index> moving = moving_columns(at.at);
  result.jacobian.setZero(result.whitened.size(), static_cast<Eigen::Index>(moving.size()));
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const auto found = std::ranges::find(here, all[static_cast<std::size_t>(moving[k])]);
    if (found != here.end())
      result.jacobian.col(static_cast<Eigen::Index>(k)) = jacobian.col(found - here.begin());
  }

  const estimation::Observations channels(next.sequences.front());
  const auto& rows = evaluator->rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const estimation::Sequence& sequence = next.sequences.front();
    const estimation::ObservationKind kind = channels.kind(sequence, rows[r].channel);
    result.kind.push_back(static_cast<int>(kind));
    if (kind != estimation::ObservationKind::force) continue;
    result.largest_force =
        std::max(result.largest_force, std::abs(result.whitened[static_cast<Eigen::Index>(r)]) *
                                           channels.sigma(sequence, rows[r].channel));
  }
  return result;
}

Bench clip_bench(const std::vector<const FieldFit*>& rivals, const FieldData& data,
                 const RigLimits& limits, int threads) {
  Bench bench;
  const std::vector<double> apart = apart_so_far(rivals, data);
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    const auto way = way_of(data.sequences[s]);
    if (!way) continue;
    bench.mountings.push_back(
        {data.sequences[s].name, static_cast<int>(s), kWayOfClips, way->reach});
    if (data.has_clock[s]) bench.fastest_per_s = std::max(bench.fastest_per_s, way->fastest_per_s);
  }
  std::ranges::stable_sort(bench.mountings, [&](const Mounting& a, const Mounting& b) {
    return apart[static_cast<std::size_t>(a.capture)] > apart[static_cast<std::size_t>(b.capture)];
  });
  if (bench.mountings.size() > kMostMountings) bench.mountings.resize(kMostMountings);
  bench.strongest =
      limits.largest_N > 0.0 ? limits.largest_N : kWiderThanCaptured * largest_force(data);
  bench.foretell = [&, threads](const Experiment& plan, const Mounting& mounting, std::size_t k) {
    return foretell(plan, *rivals[k], data, mounting.capture, threads);
  };
  return bench;
}

}  // namespace tenter::diagnosis
