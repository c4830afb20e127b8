// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/discretisation/grid_error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "common/base/not_a_number.h"
#include "server/estimation/parallel.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/law.h"

namespace tenter::estimation {

namespace {

double length_of(const mechanics::SurfaceMesh& mesh) {
  double area = 0.0, count = 0.0;
  for (int k = 0; k < mesh.triangle_count(); ++k) {
    const auto& t = mesh.triangles[static_cast<std::size_t>(k)];
    const Eigen::Vector2d a = mesh.material_m.col(t[1]) - mesh.material_m.col(t[0]),
                          b = mesh.material_m.col(t[2]) - mesh.material_m.col(t[0]);
    area += mesh.weight(k) * (a.x() * b.y() - a.y() * b.x());
    count += mesh.weight(k);
  }
  return std::sqrt(area / count);
}

bool have_same_channels(const Sequence& a, const Sequence& b) {
  if (a.points.size() != b.points.size() || a.forces.size() != b.forces.size() ||
      a.scalars.size() != b.scalars.size() || a.frames.size() != b.frames.size())
    return false;
  for (std::size_t k = 0; k < a.points.size(); ++k)
    if (a.points[k].material_m != b.points[k].material_m) return false;
  for (std::size_t k = 0; k < a.forces.size(); ++k)
    if (a.forces[k].clip != b.forces[k].clip || a.forces[k].direction != b.forces[k].direction)
      return false;
  const Observations of_a(a), of_b(b);
  for (int c = 0; c < of_a.count(); ++c)
    if (of_a.kind(a, c) != of_b.kind(b, c) || of_a.sigma(a, c) != of_b.sigma(b, c)) return false;
  return true;
}

/// Simulated minus measured, in sigmas.
struct FrameRow {
  int channel = 0;
  double residual = 0.0;
};
/// [frame]; none where the frame finds no rest.
using Frames = std::vector<std::optional<std::vector<FrameRow>>>;

/// Puts the rows of these frames into `frames`; false where one of them finds no rest.
Expected<bool> fill(const model::Model& model, Sequence part, std::size_t first, int threads,
                    Frames& frames) {
  SequenceOptions how;
  how.threads = threads;
  const std::size_t count = part.frames.size();
  auto evaluator = SequenceEvaluator::make(model, {std::move(part)}, how);
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd residuals;
  if (evaluator->evaluate(mechanics::term_parameters(model), residuals, nullptr) !=
      mechanics::PathStatus::ok)
    return false;
  for (std::size_t f = 0; f < count; ++f) frames[first + f].emplace();
  for (std::size_t r = 0; r < evaluator->rows().size(); ++r) {
    const Row& row = evaluator->rows()[r];
    frames[first + static_cast<std::size_t>(row.frame)]->push_back(
        {row.channel, residuals[static_cast<Eigen::Index>(r)]});
  }
  return true;
}

/// The frames before the first without a rest: what a model that remembers can be asked for.
Expected<Frames> on_path(const model::Model& model, Sequence sequence, int threads) {
  Frames frames(sequence.frames.size());
  const auto rest = resting_frames(model, sequence, mechanics::term_parameters(model),
                                   SequenceOptions().tolerance_N);
  if (!rest) return tl::unexpected(rest.error());
  if (rest->restless.empty()) return frames;  // it was found once and not again
  sequence.frames.resize(static_cast<std::size_t>(rest->restless.front().frame));
  if (sequence.frames.empty()) return frames;
  const auto filled = fill(model, std::move(sequence), 0, threads, frames);
  if (!filled) return tl::unexpected(filled.error());
  return frames;
}

/// All frames together; where one finds no rest, each by itself, but of a model that remembers,
/// whose frames are one path.
Expected<Frames> frames_of(const model::Model& model, const Sequence& sequence, int threads) {
  Frames frames(sequence.frames.size());
  const auto together = fill(model, sequence, 0, threads, frames);
  if (!together) return tl::unexpected(together.error());
  const auto bound = mechanics::MeshModel::make(model, sequence.cloth);
  if (*together) return frames;
  if (bound && bound->history_count() > 0) return on_path(model, sequence, threads);
  std::vector<std::optional<Error>> trouble(frames.size());
  in_parallel(threads, static_cast<int>(frames.size()), [&](int, int i) {
    const auto f = static_cast<std::size_t>(i);
    Sequence one = sequence;
    one.frames = {sequence.frames[f]};
    if (one.frames.front().start) one.start = *one.frames.front().start;
    if (auto done = fill(model, std::move(one), f, 1, frames); !done) trouble[f] = done.error();
  });
  for (const auto& error : trouble)
    if (error) return tl::unexpected(*error);
  return frames;
}

double value_of(const Sequence& sequence, int channel, const GridError::Frame& frame) {
  const int first_force = 3 * static_cast<int>(sequence.points.size());
  const int first_scalar = first_force + static_cast<int>(sequence.forces.size());
  if (channel < first_force) return frame.points_m(channel % 3, channel / 3);
  if (channel < first_scalar) return frame.forces_N[channel - first_force];
  return frame.scalars[channel - first_scalar];
}

/// Puts the difference of a channel's simulated values where its measured one is.
void put(const Sequence& sequence, int channel, double value, GridError::Frame& frame) {
  const int first_force = 3 * static_cast<int>(sequence.points.size());
  const int first_scalar = first_force + static_cast<int>(sequence.forces.size());
  if (channel < first_force)
    frame.points_m(channel % 3, channel / 3) = value;
  else if (channel < first_scalar)
    frame.forces_N[channel - first_force] = value;
  else
    frame.scalars[channel - first_scalar] = value;
}

/// Root mean square over the frames that have an estimate.
template <class Of>
double rms_over_frames(const GridError& error, const Of& of) {
  double squares = 0.0;
  int count = 0;
  for (const GridError::Frame& frame : error.frames)
    if (frame.rests) {
      squares += std::pow(of(frame), 2);
      ++count;
    }
  return count > 0 ? std::sqrt(squares / count) : 0.0;
}

double& sigma_of(ScalarChannel& channel) {
  if (auto* torque = std::get_if<TorqueChannel>(&channel)) return torque->sigma_N_m;
  if (auto* length = std::get_if<LengthChannel>(&channel)) return length->sigma_m;
  return std::get<AreaChannel>(channel).sigma_m2;
}

double wider(double sigma, double share, double error) {
  return std::hypot(sigma, share * error);
}

}  // namespace

Expected<GridError> grid_error(const model::Model& model, const Sequence& coarse,
                               const Sequence& fine, const GridErrorOptions& options) {
  if (!(options.order > 0.0) || !(options.share_as_sigma >= 0.0) || !std::isfinite(options.order) ||
      !std::isfinite(options.share_as_sigma))
    return bad_input("the order of a grid's error is above 0, the share as sigma at least 0");
  for (const Sequence* sequence : {&coarse, &fine})
    if (auto ok = check(*sequence); !ok) return tl::unexpected(ok.error());
  if (!have_same_channels(coarse, fine))
    return bad_input("sequence \"" + coarse.name + "\" has other channels on the finer grid");
  const double ratio = length_of(fine.cloth.mesh) / length_of(coarse.cloth.mesh);
  if (!(ratio < 1.0))
    return bad_input("sequence \"" + coarse.name + "\": the fine grid is no finer");
  const double factor = 1.0 / (1.0 - std::pow(ratio, options.order));

  const Observations channels(coarse);
  GridError error;
  error.share_as_sigma = options.share_as_sigma;
  const auto on_coarse = frames_of(model, coarse, options.threads);
  if (!on_coarse) return tl::unexpected(on_coarse.error());
  const auto on_fine = frames_of(model, fine, options.threads);
  if (!on_fine) return tl::unexpected(on_fine.error());
  for (std::size_t f = 0; f < coarse.frames.size(); ++f) {
    GridError::Frame& frame = error.frames.emplace_back();
    frame.points_m.setZero(3, static_cast<Eigen::Index>(coarse.points.size()));
    frame.forces_N.setZero(static_cast<Eigen::Index>(coarse.forces.size()));
    frame.scalars.setZero(static_cast<Eigen::Index>(coarse.scalars.size()));
    const auto &a = (*on_coarse)[f], &b = (*on_fine)[f];
    if (!a || !b) continue;
    if (a->size() != b->size())
      return bad_input("sequence \"" + coarse.name + "\", frame " + std::to_string(f + 1) +
                       ": other values are measured on the finer grid");
    frame.rests = true;
    for (std::size_t r = 0; r < a->size(); ++r) {
      const int channel = (*a)[r].channel;
      if (channels.kind(coarse, channel) == ObservationKind::position && !options.of_positions)
        continue;
      // both are (simulated - measured) / sigma of the same measured value
      put(coarse, channel,
          factor * ((*b)[r].residual - (*a)[r].residual) * channels.sigma(coarse, channel), frame);
    }
  }
  return error;
}

Sequence without_grid_error(Sequence sequence, const GridError& error) {
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    SequenceFrame& frame = sequence.frames[f];
    const GridError::Frame& off = error.frames[f];
    if (!off.rests) {
      frame.forces_N.setConstant(kNaN);
      frame.scalars.setConstant(kNaN);
      continue;
    }
    frame.points_m -= off.points_m;
    frame.forces_N -= off.forces_N;
    if (frame.scalars.size() > 0) frame.scalars -= off.scalars;
  }
  const double share = error.share_as_sigma;
  for (std::size_t k = 0; k < sequence.points.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    // a coordinate's
    const double rms = rms_over_frames(error, [&](const GridError::Frame& frame) {
      return frame.points_m.col(column).norm() / std::sqrt(3.0);
    });
    sequence.points[k].sigma_m = wider(sequence.points[k].sigma_m, share, rms);
  }
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const double rms = rms_over_frames(error, [&](const GridError::Frame& frame) {
      return frame.forces_N[static_cast<Eigen::Index>(k)];
    });
    sequence.forces[k].sigma_N = wider(sequence.forces[k].sigma_N, share, rms);
  }
  for (std::size_t k = 0; k < sequence.scalars.size(); ++k) {
    const double rms = rms_over_frames(error, [&](const GridError::Frame& frame) {
      return frame.scalars[static_cast<Eigen::Index>(k)];
    });
    double& sigma = sigma_of(sequence.scalars[k]);
    sigma = wider(sigma, share, rms);
  }
  return sequence;
}

GridErrorSize size_of(const GridError& error, const Sequence& sequence, ObservationKind kind) {
  const Observations channels(sequence);
  GridErrorSize size;
  for (std::size_t f = 0; f < error.frames.size(); ++f) {
    if (!error.frames[f].rests) continue;
    for (int c = 0; c < channels.count(); ++c) {
      if (channels.kind(sequence, c) != kind ||
          std::isnan(channels.measured(sequence.frames[f], c)))
        continue;
      const double value = value_of(sequence, c, error.frames[f]);
      ++size.rows;
      size.rms += value * value;
      size.sigmas += std::pow(value / channels.sigma(sequence, c), 2);
      size.largest = std::max(size.largest, std::abs(value));
    }
  }
  if (size.rows == 0) return size;
  size.rms = std::sqrt(size.rms / size.rows);
  size.sigmas = std::sqrt(size.sigmas / size.rows);
  return size;
}

}  // namespace tenter::estimation
