// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/resting_frames.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "common/model/catalogue.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::estimation {

Expected<RestingFrames> resting_frames(const model::Model& model, const Sequence& sequence,
                                       const Eigen::VectorXd& parameters, double tolerance_N) {
  if (auto ok = check(sequence); !ok) return tl::unexpected(ok.error());
  const auto bound = mechanics::MeshModel::make(model, sequence.cloth);
  if (!bound) return tl::unexpected(bound.error());
  std::vector<std::unique_ptr<mechanics::EquilibriumSolver>> solvers(sequence.boundaries.size());
  RestingFrames found;
  mechanics::State state = sequence.start;
  mechanics::EquilibriumOptions options;
  options.tolerance_N = tolerance_N;
  options.predict = false;
  mechanics::History history = bound->never_strained();
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const SequenceFrame& frame = sequence.frames[f];
    auto& solver = solvers[static_cast<std::size_t>(frame.boundary)];
    if (!solver) {
      auto made = mechanics::EquilibriumSolver::make(
          *bound, sequence.boundaries[static_cast<std::size_t>(frame.boundary)]);
      if (!made) return tl::unexpected(made.error());
      solver = std::make_unique<mechanics::EquilibriumSolver>(std::move(*made));
    }
    mechanics::State at = frame.start ? *frame.start : state;
    prescribe(sequence, f, true, at);
    mechanics::Loads loads = sequence.loads;
    loads.cord_force_N = frame.cord_force_N;
    history.duration_s = frame.duration_s;
    auto solved = solver->solve(parameters, loads, at, options, &history);
    if (solved && solved->is_good(options) &&
        bound->end_of_step(at.x, parameters, history, history.state) ==
            mechanics::AssemblyStatus::ok) {
      found.resting.push_back(static_cast<int>(f));
      found.by_node_N.push_back(std::move(solved->by_node));
      found.states.push_back(at);
      state = std::move(at);
    } else {
      found.restless.push_back(
          {static_cast<int>(f), solved ? describe(*solved, options) : solved.error().message});
    }
  }
  return found;
}

std::vector<int> even_frames(int all, int most) {
  const int count = std::min(all, std::max(1, most));
  std::vector<int> frames;
  for (int k = 1; k <= count; ++k) frames.push_back((k * all + count - 1) / count - 1);
  return frames;
}

std::vector<int> taken_frames(const model::Model& model, int all, int most) {
  return even_frames(all, model::remembers_path(model) ? all : most);
}

void keep_frames(Sequence& sequence, const std::vector<int>& frames) {
  std::vector<SequenceFrame> kept;
  kept.reserve(frames.size());
  for (const int f : frames)
    kept.push_back(std::move(sequence.frames[static_cast<std::size_t>(f)]));
  sequence.frames = std::move(kept);
}

}  // namespace tenter::estimation
