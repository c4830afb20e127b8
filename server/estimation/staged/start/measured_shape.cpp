// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/start/measured_shape.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace tenter::estimation {

using mechanics::PotentialValue;
using mechanics::State;

Expected<MeasuredShape> MeasuredShape::make(const mechanics::MeshModel& model,
                                            const Sequence& sequence) {
  if (auto ok = check(sequence); !ok) return tl::unexpected(ok.error());
  MeasuredShape shape(model, sequence);
  double sum = 0.0;
  for (const PointChannel& point : sequence.points) {
    shape.locations_.push_back(*locate(sequence.cloth.mesh, point.material_m));
    sum += point.sigma_m * point.sigma_m;
  }
  shape.sigma_m_ =
      std::sqrt(sum / std::max<double>(1.0, static_cast<double>(sequence.points.size())));
  const auto& material = sequence.cloth.mesh.material_m;
  // the far corner of a hinge as an affine combination of the other three
  double length = 0.0;
  for (const mechanics::Hinge& hinge : sequence.cloth.hinges) {
    Eigen::Matrix3d corners;
    Eigen::Vector3d far(1.0, 0.0, 0.0);
    for (Eigen::Index c = 0; c < 3; ++c)
      corners.col(c) << 1.0, material.col(hinge.nodes[static_cast<std::size_t>(c)]);
    far.tail<2>() = material.col(hinge.nodes[3]);
    const Eigen::Vector3d w = corners.inverse() * far;
    shape.stencils_.push_back({hinge.nodes, {w[0], w[1], w[2], -1.0}});
    length += (material.col(hinge.nodes[0]) - material.col(hinge.nodes[1])).norm();
  }
  shape.edge_m_ = length / std::max<double>(1.0, static_cast<double>(shape.stencils_.size()));
  shape.sites_.resize(sequence.boundaries.size());
  return shape;
}

const mechanics::Boundary& MeasuredShape::boundary(std::size_t frame) const {
  return sequence_->boundaries[static_cast<std::size_t>(sequence_->frames[frame].boundary)];
}

mechanics::Loads MeasuredShape::loads(std::size_t frame) const {
  mechanics::Loads loads = sequence_->loads;
  loads.cord_force_N = sequence_->frames[frame].cord_force_N;
  return loads;
}

MeasuredShape::Site& MeasuredShape::site(std::size_t frame) {
  Site& site = sites_[static_cast<std::size_t>(sequence_->frames[frame].boundary)];
  if (!site.unknowns) {
    site.unknowns = std::make_unique<mechanics::Unknowns>(boundary(frame), model_->matrix());
    site.factor = mechanics::make_factor();
    site.factor->analyze(site.unknowns->pattern());
  }
  return site;
}

bool MeasuredShape::is_measured(std::size_t frame, std::size_t point) const {
  return sequence_->frames[frame].points_m.col(static_cast<Eigen::Index>(point)).allFinite();
}

bool MeasuredShape::fill(std::size_t frame, State& state) {
  const int nodes = model_->node_count();
  const State before = state;
  prescribe(*sequence_, frame, true, state);
  mechanics::place_clips(boundary(frame), state);
  // d is known at what is held or clamped
  std::vector<int> place(static_cast<std::size_t>(nodes), 0);
  for (const int n : boundary(frame).held) place[static_cast<std::size_t>(n)] = -1;
  for (const mechanics::Clip& clip : boundary(frame).clips)
    for (const int n : clip.nodes) place[static_cast<std::size_t>(n)] = -1;
  int count = 0;
  for (int& p : place)
    if (p == 0) p = count++;
  if (count == 0) return true;

  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count, 3);
  const auto at = [](const Eigen::VectorXd& x, int n) {
    return x.segment<3>(3 * static_cast<Eigen::Index>(n));
  };
  const auto add = [&](const int* of, const double* weight, std::size_t corners, double factor,
                       Eigen::Vector3d target) {
    for (std::size_t a = 0; a < corners; ++a)
      if (place[static_cast<std::size_t>(of[a])] < 0)
        target -= weight[a] * (at(state.x, of[a]) - at(before.x, of[a]));
    for (std::size_t a = 0; a < corners; ++a) {
      const int i = place[static_cast<std::size_t>(of[a])];
      if (i < 0) continue;
      right.row(i) += factor * weight[a] * target.transpose();
      for (std::size_t b = 0; b < corners; ++b)
        if (const int j = place[static_cast<std::size_t>(of[b])]; j >= 0)
          entries.emplace_back(i, j, factor * weight[a] * weight[b]);
    }
  };
  for (std::size_t k = 0; k < locations_.size(); ++k) {
    if (!is_measured(frame, k)) continue;
    const MaterialLocation& location = locations_[k];
    const Eigen::Vector3d seen =
        sequence_->frames[frame].points_m.col(static_cast<Eigen::Index>(k));
    add(location.nodes.data(), location.weight.data(), 3, 1.0, seen - location.position(before.x));
  }
  // a second difference of 0.01 of an edge is what a frame may change by itself
  const double alpha = std::max(1e-6, std::pow(sigma_m_ / (0.01 * edge_m_), 2));
  for (const Stencil& stencil : stencils_)
    add(stencil.nodes.data(), stencil.weight.data(), 4, alpha, Eigen::Vector3d::Zero());
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1e-12);
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::MatrixX3d moved = factor.solve(right);
  for (int n = 0; n < nodes; ++n)
    if (const int i = place[static_cast<std::size_t>(n)]; i >= 0)
      state.x.segment<3>(3 * static_cast<Eigen::Index>(n)) += moved.row(i).transpose();
  return state.x.allFinite();
}

double MeasuredShape::spring_stiffness(std::size_t frame, const PotentialValue& value) {
  const mechanics::SymmetricPattern& pattern = site(frame).unknowns->pattern();
  double sum = 0.0;
  for (int j = 0; j < pattern.size; ++j)
    sum +=
        value
            .stiffness[static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)])];
  return sum / pattern.size * std::pow(1e-3 * edge_m_ / std::max(sigma_m_, 1e-9 * edge_m_), 2);
}

double MeasuredShape::spring_energy(std::size_t frame, double stiffness,
                                    const Eigen::VectorXd& x) const {
  double energy = 0.0;
  for (std::size_t k = 0; k < locations_.size(); ++k)
    if (is_measured(frame, k))
      energy += 0.5 * stiffness *
                (locations_[k].position(x) -
                 sequence_->frames[frame].points_m.col(static_cast<Eigen::Index>(k)))
                    .squaredNorm();
  return energy;
}

void MeasuredShape::add_springs(std::size_t frame, double stiffness, const State& state,
                                PotentialValue& value) const {
  for (std::size_t k = 0; k < locations_.size(); ++k) {
    if (!is_measured(frame, k)) continue;
    const MaterialLocation& place = locations_[k];
    const Eigen::Vector3d pull =
        stiffness * (place.position(state.x) -
                     sequence_->frames[frame].points_m.col(static_cast<Eigen::Index>(k)));
    for (std::size_t a = 0; a < 3; ++a) {
      value.by_node.segment<3>(3 * static_cast<Eigen::Index>(place.nodes[a])) +=
          place.weight[a] * pull;
      for (std::size_t b = 0; b < 3; ++b) {
        if (place.nodes[a] < place.nodes[b]) continue;  // the lower triangle
        double* block =
            value.node_stiffness.block(value.node_stiffness.slot(place.nodes[a], place.nodes[b]));
        for (int c = 0; c < 3; ++c) block[4 * c] += stiffness * place.weight[a] * place.weight[b];
      }
    }
  }
}

bool MeasuredShape::settle(std::size_t frame, const Eigen::VectorXd& parameters, State& state,
                           const mechanics::History* history) {
  constexpr int kMostSteps = 12;
  constexpr double kEnough = 1e-3;  // of the net force that the first shape has
  const mechanics::Loads frame_loads = loads(frame);
  const mechanics::Contact no_contact;
  Site& here = site(frame);
  const mechanics::Potential potential(*model_, parameters, boundary(frame), *here.unknowns,
                                       frame_loads, no_contact, nullptr, history);
  PotentialValue value;
  State moved = state;
  Eigen::VectorXd step(here.unknowns->count());
  double stiffness = 0.0;
  double first_force = 0.0;
  for (int turn = 0; turn < kMostSteps; ++turn) {
    if (!potential.evaluate_with_stiffness(state, 1.0, value)) return false;
    if (turn == 0) stiffness = spring_stiffness(frame, value);
    const double energy = value.energy_J + spring_energy(frame, stiffness, state.x);
    add_springs(frame, stiffness, state, value);
    here.unknowns->reduce_matrix(frame_loads, state, value.by_node, value.node_stiffness, 1.0,
                                 value.stiffness);
    here.unknowns->reduce_gradient(frame_loads, state, value.by_node, value.by_unknown);
    const double force = value.by_unknown.norm();
    if (turn == 0) first_force = force;
    if (force <= kEnough * first_force) return true;
    if (here.factor->factorize(value.stiffness.data()) != mechanics::FactorStatus::ok) return false;
    here.factor->solve(value.by_unknown.data(), step.data(), 1);
    step = -step;
    const double slope = value.by_unknown.dot(step);
    bool is_better = false;
    for (double fraction = 1.0; fraction > 1e-3 && !is_better; fraction *= 0.5) {
      here.unknowns->move(state, step, fraction, moved);
      const double now = potential.energy_J(moved) + spring_energy(frame, stiffness, moved.x);
      is_better = now <= energy + 1e-4 * fraction * slope;
    }
    if (!is_better) return true;  // down to rounding
    std::swap(state, moved);
  }
  return true;
}

}  // namespace tenter::estimation
