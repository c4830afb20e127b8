// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/unknowns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "server/mechanics/raise_eigenvalues.h"

namespace tenter::mechanics {
namespace {

constexpr int kBodyUnknowns = 6;

/// Second derivative of f . R(w) r by w at w = 0.
Eigen::Matrix3d turn_curvature(const Eigen::Vector3d& f, const Eigen::Vector3d& r) {
  return 0.5 * (f * r.transpose() + r * f.transpose()) - f.dot(r) * Eigen::Matrix3d::Identity();
}

}  // namespace

Unknowns::Unknowns(const Boundary& boundary, const NodeMatrix& matrix) : boundary_(boundary) {
  const auto nodes = static_cast<std::size_t>(matrix.node_count());
  std::vector<bool> is_free(nodes, true);
  std::vector<int> body_of(nodes, -1);
  for (const int node : boundary.held) is_free[static_cast<std::size_t>(node)] = false;
  for (const Clip& clip : boundary.clips)
    for (const int node : clip.nodes) is_free[static_cast<std::size_t>(node)] = false;
  first_unknown_.assign(nodes, -1);
  int size = 0;
  for (std::size_t n = 0; n < nodes; ++n) {
    if (!is_free[n]) continue;
    first_unknown_[n] = size;
    free_nodes_.push_back(static_cast<int>(n));
    size += 3;
  }
  for (std::size_t c = 0; c < boundary.clips.size(); ++c) {
    const Clip& clip = boundary.clips[c];
    if (!clip.is_free) continue;
    Body body;
    body.clip = static_cast<int>(c);
    body.first_unknown = size;
    size += kBodyUnknowns;
    for (const Eigen::Vector3d& place : clip.place_m)
      body.middle_m += place / static_cast<double>(clip.place_m.size());
    for (const Eigen::Vector3d& place : clip.place_m)
      body.arm_m += (place - body.middle_m).squaredNorm();
    body.arm_m = std::sqrt(body.arm_m / static_cast<double>(clip.place_m.size()));
    if (body.arm_m == 0.0) body.arm_m = 1.0;  // a clip of one node: torques count as they are
    for (const int node : clip.nodes)
      body_of[static_cast<std::size_t>(node)] = static_cast<int>(bodies_.size());
    bodies_.push_back(body);
  }

  const auto unknowns_of = [&](int node) {
    std::vector<int> list;
    const auto n = static_cast<std::size_t>(node);
    const int first = body_of[n] >= 0 ? bodies_[static_cast<std::size_t>(body_of[n])].first_unknown
                                      : first_unknown_[n];
    const int wanted = body_of[n] >= 0 ? kBodyUnknowns : 3;
    for (int k = 0; first >= 0 && k < wanted; ++k) list.push_back(first + k);
    return list;
  };
  std::vector<std::vector<int>> coupled;
  const auto each_block = [&](const auto& visit) {
    for (int j = 0; j < matrix.node_count(); ++j)
      for (int s = matrix.column_start()[static_cast<std::size_t>(j)];
           s < matrix.column_start()[static_cast<std::size_t>(j) + 1]; ++s)
        visit(s, matrix.row()[static_cast<std::size_t>(s)], j);
  };
  each_block([&](int, int i, int j) {
    std::vector<int> both = unknowns_of(i);
    const std::vector<int> more = unknowns_of(j);
    both.insert(both.end(), more.begin(), more.end());
    if (!both.empty()) coupled.push_back(std::move(both));
  });
  pattern_ = element_pattern(size, coupled);

  each_block([&](int s, int i, int j) {
    const std::vector<int> rows = unknowns_of(i);
    const std::vector<int> columns = unknowns_of(j);
    if (rows.empty() || columns.empty()) return;
    const int row_body = body_of[static_cast<std::size_t>(i)];
    const int column_body = body_of[static_cast<std::size_t>(j)];
    if (row_body < 0 && column_body < 0) {
      FreeBlock block{s, i == j, {}};
      for (std::size_t c = 0; c < 3; ++c)
        block.slots[c] = pattern_.slot(rows[i == j ? c : 0], columns[c]);
      free_blocks_.push_back(block);
      return;
    }
    BodyBlock block{s, i, j, row_body, column_body, {}};
    for (const int column : columns)
      for (const int row : rows) block.slots.push_back(pattern_.slot(row, column));
    body_blocks_.push_back(std::move(block));
  });
}

Eigen::Matrix<double, 3, 6> Unknowns::jacobian(const Body& body, const State& state,
                                               int node) const {
  Eigen::Matrix<double, 3, 6> j;
  j.leftCols<3>() = -cross_matrix(state.x.segment<3>(3 * node) - middle(body, state));
  j.rightCols<3>().setIdentity();
  return j;
}

void Unknowns::restrict_to(const State& state, const Eigen::VectorXd& by_node,
                           Eigen::VectorXd& by_unknown) const {
  by_unknown.resize(count());
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    by_unknown.segment<3>(3 * static_cast<Eigen::Index>(k)) =
        by_node.segment<3>(3 * static_cast<Eigen::Index>(free_nodes_[k]));
  for (const Body& body : bodies_) {
    const Wrench inner = reaction(boundary_.clips[static_cast<std::size_t>(body.clip)], state.x,
                                  by_node, middle(body, state));
    by_unknown.segment<3>(body.first_unknown) = -inner.torque_N_m;
    by_unknown.segment<3>(body.first_unknown + 3) = -inner.force_N;
  }
}

void Unknowns::reduce_gradient(const Loads& loads, const State& state,
                               const Eigen::VectorXd& by_node, Eigen::VectorXd& by_unknown) const {
  restrict_to(state, by_node, by_unknown);
  for (const Body& body : bodies_) {
    const Wrench outer =
        outer_wrench(loads, boundary_, body.clip, state.clips[static_cast<std::size_t>(body.clip)],
                     middle(body, state));
    by_unknown.segment<3>(body.first_unknown) -= outer.torque_N_m;
    by_unknown.segment<3>(body.first_unknown + 3) -= outer.force_N;
  }
}

void Unknowns::reduce_matrix(const Loads& loads, const State& state, const Eigen::VectorXd& by_node,
                             const NodeMatrix& matrix, double positive_share,
                             std::vector<double>& values) const {
  values.resize(static_cast<std::size_t>(pattern_.entry_count()));
  for (const FreeBlock& b : free_blocks_) {
    const double* block = matrix.block(b.block);
    for (int c = 0; c < 3; ++c) {
      double* to = values.data() + b.slots[c];
      for (int r = b.is_diagonal ? c : 0; r < 3; ++r) *to++ = block[3 * c + r];
    }
  }
  if (bodies_.empty()) return;

  for (const BodyBlock& b : body_blocks_)
    for (const int s : b.slots)
      if (s >= 0) values[static_cast<std::size_t>(s)] = 0.0;
  Eigen::Matrix<double, 6, 6> product;
  for (const BodyBlock& b : body_blocks_) {
    const Eigen::Map<const Eigen::Matrix3d> k(matrix.block(b.block));
    Eigen::Matrix<double, 6, 3> left;
    int rows = 3;
    if (b.row_body >= 0) {
      rows = kBodyUnknowns;
      left.noalias() =
          jacobian(bodies_[static_cast<std::size_t>(b.row_body)], state, b.row_node).transpose() *
          k;
    } else {
      left.topRows<3>() = k;
    }
    int columns = 3;
    if (b.column_body >= 0) {
      columns = kBodyUnknowns;
      product.topRows(rows).noalias() =
          left.topRows(rows) *
          jacobian(bodies_[static_cast<std::size_t>(b.column_body)], state, b.column_node);
    } else {
      product.topLeftCorner(rows, 3) = left.topRows(rows);
    }
    const bool is_mirrored =
        b.row_body >= 0 && b.row_body == b.column_body && b.row_node != b.column_node;
    // two different nodes of one clip: the block above the diagonal adds to the same entries
    if (is_mirrored) product = (product + product.transpose()).eval();
    const bool same_body = b.row_body >= 0 && b.row_body == b.column_body;
    for (int c = 0; c < columns; ++c)
      for (int r = same_body ? c : 0; r < rows; ++r)
        values[static_cast<std::size_t>(b.slots[static_cast<std::size_t>(c * rows + r)])] +=
            product(r, c);
  }
  for (const Body& body : bodies_) {
    const auto clip_index = static_cast<std::size_t>(body.clip);
    const Clip& clip = boundary_.clips[clip_index];
    const Pose& pose = state.clips[clip_index];
    const Eigen::Vector3d about = middle(body, state);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    for (const int node : clip.nodes)
      turn += turn_curvature(by_node.segment<3>(3 * node), state.x.segment<3>(3 * node) - about);
    turn -= turn_curvature(clip.mass_kg * loads.gravity_m_s2,
                           pose.to_space(clip.centre_of_mass_m) - about);
    for (std::size_t k = 0; !loads.cord_force_N.empty() && k < clip.cord_place_m.size(); ++k)
      turn -= turn_curvature(loads.cord_force_N[clip_index][k],
                             pose.to_space(clip.cord_place_m[k]) - about);
    if (positive_share > 0.0) raise_eigenvalues(turn, positive_share);
    for (int c = 0; c < 3; ++c)
      for (int r = c; r < 3; ++r)
        values[static_cast<std::size_t>(
            pattern_.slot(body.first_unknown + r, body.first_unknown + c))] += turn(r, c);
  }
}

const Unknowns::Body& Unknowns::body_of_clip(int clip) const {
  return *std::find_if(bodies_.begin(), bodies_.end(),
                       [clip](const Body& body) { return body.clip == clip; });
}

void Unknowns::add_spring_gradient(const ClipSpring& spring, const State& state,
                                   Eigen::VectorXd& by_unknown) const {
  const Body& body = body_of_clip(spring.clip);
  const Eigen::Vector3d point =
      state.clips[static_cast<std::size_t>(spring.clip)].to_space(spring.place_m);
  const Eigen::Vector3d slope = spring.stiffness_N_m * (point - spring.target_m);
  by_unknown.segment<3>(body.first_unknown) += (point - middle(body, state)).cross(slope);
  by_unknown.segment<3>(body.first_unknown + 3) += slope;
}

void Unknowns::add_spring_stiffness(const ClipSpring& spring, const State& state,
                                    double positive_share, std::vector<double>& values) const {
  const Body& body = body_of_clip(spring.clip);
  const Eigen::Vector3d point =
      state.clips[static_cast<std::size_t>(spring.clip)].to_space(spring.place_m);
  const Eigen::Vector3d arm = point - middle(body, state);
  Eigen::Matrix<double, 3, 6> j;
  j.leftCols<3>() = -cross_matrix(arm);
  j.rightCols<3>().setIdentity();
  Eigen::Matrix<double, 6, 6> block = spring.stiffness_N_m * j.transpose() * j;
  Eigen::Matrix3d turn = turn_curvature(spring.stiffness_N_m * (point - spring.target_m), arm);
  if (positive_share > 0.0) raise_eigenvalues(turn, positive_share);
  block.topLeftCorner<3, 3>() += turn;
  for (int c = 0; c < kBodyUnknowns; ++c)
    for (int r = c; r < kBodyUnknowns; ++r)
      values[static_cast<std::size_t>(
          pattern_.slot(body.first_unknown + r, body.first_unknown + c))] += block(r, c);
}

void Unknowns::expand(const State& state, const Eigen::VectorXd& by_unknown,
                      Eigen::VectorXd& by_node) const {
  by_node.setZero(state.x.size());
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    by_node.segment<3>(3 * free_nodes_[k]) =
        by_unknown.segment<3>(3 * static_cast<Eigen::Index>(k));
  for (const Body& body : bodies_)
    for (const int node : boundary_.clips[static_cast<std::size_t>(body.clip)].nodes)
      by_node.segment<3>(3 * node) =
          jacobian(body, state, node) * by_unknown.segment<6>(body.first_unknown);
}

void Unknowns::move(const State& state, const Eigen::VectorXd& step, double fraction,
                    State& moved) const {
  moved = state;
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    moved.x.segment<3>(3 * free_nodes_[k]) +=
        fraction * step.segment<3>(3 * static_cast<Eigen::Index>(k));
  for (const Body& body : bodies_) {
    const auto c = static_cast<std::size_t>(body.clip);
    const Pose& from = state.clips[c];
    Pose& to = moved.clips[c];
    const Eigen::Matrix3d turn = rotation_of(fraction * step.segment<3>(body.first_unknown));
    const Eigen::Vector3d about = middle(body, state);
    to.rotation = Eigen::Quaterniond(turn * from.rotation).normalized().toRotationMatrix();
    to.position_m =
        about + fraction * step.segment<3>(body.first_unknown + 3) - to.rotation * body.middle_m;
    const Clip& clip = boundary_.clips[c];
    for (std::size_t i = 0; i < clip.nodes.size(); ++i)
      moved.x.segment<3>(3 * clip.nodes[i]) = to.to_space(clip.place_m[i]);
  }
}

double Unknowns::net_force_N(const Eigen::VectorXd& by_unknown) const {
  double squared = by_unknown.head(3 * static_cast<Eigen::Index>(free_nodes_.size())).squaredNorm();
  for (const Body& body : bodies_)
    squared += by_unknown.segment<3>(body.first_unknown).squaredNorm() / (body.arm_m * body.arm_m) +
               by_unknown.segment<3>(body.first_unknown + 3).squaredNorm();
  return std::sqrt(squared);
}

double Unknowns::longest_move_m(const Eigen::VectorXd& step) const {
  double longest = 0.0;
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    longest = std::max(longest, step.segment<3>(3 * static_cast<Eigen::Index>(k)).norm());
  for (const Body& body : bodies_)
    longest = std::max({longest, body.arm_m * step.segment<3>(body.first_unknown).norm(),
                        step.segment<3>(body.first_unknown + 3).norm()});
  return longest;
}

}  // namespace tenter::mechanics
