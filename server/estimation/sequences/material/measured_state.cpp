// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material/measured_state.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace tenter::estimation {

namespace {

constexpr double kTiny = 1e-9;  // of an edge: keeps a sheet of which nothing is known in place

std::vector<std::pair<int, int>> edges_of(const mechanics::SurfaceMesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t a = 0; a < 3; ++a)
      edges.emplace_back(std::min(t[a], t[(a + 1) % 3]), std::max(t[a], t[(a + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

MeasuredStates::MeasuredStates(const mechanics::SurfaceMesh& mesh,
                               std::vector<MaterialLocation> points)
    : mesh_(mesh), points_(std::move(points)), edges_(edges_of(mesh)) {}

void MeasuredStates::factorise(const std::vector<bool>& is_fixed,
                               const std::vector<bool>& is_seen) {
  if (has_factor_ && is_fixed == fixed_ && is_seen == seen_) return;
  fixed_ = is_fixed;
  seen_ = is_seen;
  has_factor_ = true;
  unknown_.assign(is_fixed.size(), -1);
  int count = 0;
  for (std::size_t n = 0; n < is_fixed.size(); ++n)
    if (!is_fixed[n]) unknown_[n] = count++;
  const auto unknown = [&](int node) { return unknown_[static_cast<std::size_t>(node)]; };
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j, double value) {
    if (i >= 0 && j >= 0) entries.emplace_back(i, j, value);
  };
  for (int i = 0; i < count; ++i) add(i, i, kTiny);
  for (const auto& [a, b] : edges_) {
    add(unknown(a), unknown(a), 1.0);
    add(unknown(b), unknown(b), 1.0);
    add(unknown(a), unknown(b), -1.0);
    add(unknown(b), unknown(a), -1.0);
  }
  for (std::size_t k = 0; k < points_.size(); ++k)
    for (std::size_t a = 0; a < 3 && is_seen[k]; ++a)
      for (std::size_t b = 0; b < 3; ++b)
        add(unknown(points_[k].nodes[a]), unknown(points_[k].nodes[b]),
            kTrust * points_[k].weight[a] * points_[k].weight[b]);
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  if (count > 0) factor_.compute(matrix);
}

double MeasuredStates::Affine::operator()(const Eigen::Vector2d& material_m) const {
  return map.head<2>().dot(material_m) + map[2];
}

Eigen::Vector2d MeasuredStates::place(const MaterialLocation& at) const {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  for (std::size_t a = 0; a < 3; ++a) place += at.weight[a] * mesh_.material_m.col(at.nodes[a]);
  return place;
}

/// Least squares through everything that is known of coordinate c, of least size where that leaves
/// it open; zero where nothing is known.
MeasuredStates::Affine MeasuredStates::affine(const std::vector<bool>& is_fixed,
                                              const Eigen::Matrix3Xd& points_m,
                                              const Eigen::VectorXd& x, Eigen::Index c) const {
  std::vector<std::pair<Eigen::Vector2d, double>> known;
  for (std::size_t n = 0; n < is_fixed.size(); ++n)
    if (is_fixed[n]) {
      const auto node = static_cast<Eigen::Index>(n);
      known.emplace_back(mesh_.material_m.col(node), x[3 * node + c]);
    }
  for (std::size_t k = 0; k < points_.size(); ++k)
    if (const double value = points_m(c, static_cast<Eigen::Index>(k)); std::isfinite(value))
      known.emplace_back(place(points_[k]), value);
  Affine affine;
  if (known.empty()) return affine;
  // (u, v) in parts of the sheet, so that the rank is judged fairly
  const double size =
      (mesh_.material_m.rowwise().maxCoeff() - mesh_.material_m.rowwise().minCoeff()).norm();
  Eigen::MatrixX3d places(static_cast<Eigen::Index>(known.size()), 3);
  Eigen::VectorXd values(places.rows());
  for (Eigen::Index row = 0; row < places.rows(); ++row) {
    const auto& [at, value] = known[static_cast<std::size_t>(row)];
    places.row(row) << at.transpose() / size, 1.0;
    values[row] = value;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-6);
  solver.compute(places);
  affine.map = solver.solve(values);
  affine.map.head<2>() /= size;
  return affine;
}

void MeasuredStates::at(const std::vector<bool>& is_fixed, const Eigen::Matrix3Xd& points_m,
                        Eigen::VectorXd& x) {
  for (Eigen::Index c = 0; c < 3; ++c) fill(is_fixed, points_m, c, x);
}

void MeasuredStates::fill(const std::vector<bool>& is_fixed, const Eigen::Matrix3Xd& points_m,
                          Eigen::Index c, Eigen::VectorXd& x) {
  std::vector<bool> is_seen(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k)
    is_seen[k] = std::isfinite(points_m(c, static_cast<Eigen::Index>(k)));
  factorise(is_fixed, is_seen);
  if (std::all_of(is_fixed.begin(), is_fixed.end(), [](bool fixed) { return fixed; })) return;
  const Affine map = affine(is_fixed, points_m, x, c);
  const auto unknown = [&](int node) { return unknown_[static_cast<std::size_t>(node)]; };
  const auto fixed_deviation = [&](int node) {
    return x[3 * node + c] - map(mesh_.material_m.col(node));
  };
  Eigen::VectorXd right = Eigen::VectorXd::Zero(factor_.rows());
  for (const auto& [a, b] : edges_) {
    if (unknown(a) >= 0 && unknown(b) < 0) right[unknown(a)] += fixed_deviation(b);
    if (unknown(b) >= 0 && unknown(a) < 0) right[unknown(b)] += fixed_deviation(a);
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (!is_seen[k]) continue;
    const MaterialLocation& point = points_[k];
    double deviation = points_m(c, static_cast<Eigen::Index>(k)) - map(place(point));
    for (std::size_t a = 0; a < 3; ++a)
      if (unknown(point.nodes[a]) < 0)
        deviation -= point.weight[a] * fixed_deviation(point.nodes[a]);
    for (std::size_t a = 0; a < 3; ++a)
      if (unknown(point.nodes[a]) >= 0)
        right[unknown(point.nodes[a])] += kTrust * point.weight[a] * deviation;
  }
  const Eigen::VectorXd deviation = factor_.solve(right);
  for (int node = 0; node < mesh_.node_count(); ++node)
    if (unknown(node) >= 0)
      x[3 * node + c] = map(mesh_.material_m.col(node)) + deviation[unknown(node)];
}

}  // namespace tenter::estimation
