// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/limits/limit_change.h"

#include <algorithm>
#include <vector>

#include "server/estimation/parallel.h"
#include "server/estimation/sequences/observations.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::estimation {
namespace {

using mechanics::EquilibriumSolver;
using mechanics::MeshModel;

struct FrameChange {
  mechanics::State state;
  Eigen::VectorXd by_node;
  mechanics::Sensitivity by_energy_max;
  bool is_active = false;
  double largest = 0.0;
};

/// The frame at rest once more, for the factor and the multipliers of that rest.
Expected<FrameChange> change_of_frame(const MeshModel& mesh, const Sequence& sequence,
                                      std::size_t frame, const mechanics::State& at_rest,
                                      const Eigen::VectorXd& parameters, const std::string& limit,
                                      double tolerance_N) {
  const SequenceFrame& measured = sequence.frames[frame];
  auto solver = EquilibriumSolver::make(
      mesh, sequence.boundaries[static_cast<std::size_t>(measured.boundary)]);
  if (!solver) return tl::unexpected(solver.error());
  FrameChange change;
  change.state = at_rest;
  mechanics::Loads loads = sequence.loads;
  loads.cord_force_N = measured.cord_force_N;
  prescribe(sequence, frame, false, change.state);
  mechanics::EquilibriumOptions options;
  options.tolerance_N = tolerance_N;
  // the multipliers begin at zero again: without them that place is far from rest
  options.start_is_near = false;
  auto solved = solver->solve(parameters, loads, change.state, options);
  if (!solved) return tl::unexpected(solved.error());
  if (!solved->is_good(options)) return fail(ErrorKind::refused, describe(*solved, options));
  auto found = sensitivity_by_energy_max(*solver, parameters, change.state, limit);
  if (!found) return tl::unexpected(found.error());
  change.by_energy_max = std::move(*found);
  change.by_node = std::move(solved->by_node);
  Eigen::VectorXd excess;
  if (mesh.limit_excess(change.state.x, parameters, excess) != mechanics::AssemblyStatus::ok)
    return fail(ErrorKind::refused, "its limited energy is not finite");
  for (const mechanics::LimitedElements& limited : mesh.limited()) {
    if (limited.limit != limit || limited.element.empty()) continue;
    const auto count = static_cast<Eigen::Index>(limited.element.size());
    change.largest = std::max(change.largest,
                              limited.energy_max + excess.segment(limited.first, count).maxCoeff());
    change.is_active |= solved->limit_multiplier.segment(limited.first, count).maxCoeff() > 0.0;
  }
  return change;
}

}  // namespace

Expected<LimitChange> limit_change(const SequenceEvaluator& evaluator, const model::Model& model,
                                   const Eigen::VectorXd& parameters, const std::string& limit,
                                   const SequenceOptions& options) {
  const std::vector<Sequence>& sequences = evaluator.sequences();
  std::vector<MeshModel> meshes;
  std::vector<std::pair<std::size_t, std::size_t>> frames;
  std::vector<std::size_t> first;  // of a sequence's frames
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    auto mesh = MeshModel::make(model, sequences[s].cloth);
    if (!mesh) return tl::unexpected(mesh.error());
    meshes.push_back(std::move(*mesh));
    first.push_back(frames.size());
    for (std::size_t f = 0; f < sequences[s].frames.size(); ++f) frames.emplace_back(s, f);
  }
  if (evaluator.states().size() != sequences.size())
    return fail(ErrorKind::refused, "the sequences were not brought to rest before");
  std::vector<Expected<FrameChange>> changes(frames.size());
  in_parallel(options.threads, static_cast<int>(frames.size()), [&](int, int k) {
    const auto [s, f] = frames[static_cast<std::size_t>(k)];
    changes[static_cast<std::size_t>(k)] =
        change_of_frame(meshes[s], sequences[s], f, evaluator.states()[s][f], parameters, limit,
                        options.tolerance_N);
  });
  LimitChange result;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!changes[k])
      return fail(changes[k].error().kind, "sequence \"" + sequences[frames[k].first].name +
                                               "\", frame " + std::to_string(frames[k].second + 1) +
                                               ": " + changes[k].error().message);
    result.active_frames += changes[k]->is_active ? 1 : 0;
    result.largest = std::max(result.largest, changes[k]->largest);
  }
  std::vector<Observations> channels(sequences.begin(), sequences.end());
  result.column.resize(evaluator.row_count());
  Observation seen;
  Eigen::RowVectorXd change;
  for (int r = 0; r < evaluator.row_count(); ++r) {
    const Row& row = evaluator.rows()[static_cast<std::size_t>(r)];
    const auto s = static_cast<std::size_t>(row.curve);
    const auto f = static_cast<std::size_t>(row.frame);
    const FrameChange& at = *changes[first[s] + f];
    const auto boundary = static_cast<std::size_t>(sequences[s].frames[f].boundary);
    channels[s].observe(sequences[s], row.channel,
                        {sequences[s].boundaries[boundary], at.state, at.by_node}, seen);
    change_of(seen, at.by_energy_max, change);
    result.column[r] = change[0] / channels[s].sigma(sequences[s], row.channel);
  }
  return result;
}

}  // namespace tenter::estimation
