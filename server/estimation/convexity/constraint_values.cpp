// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "server/estimation/convexity/convexity_constraints.h"

namespace tenter::estimation {
namespace {

/// The lower eigenvalue of a symmetric 2 x 2 matrix (h11, h12, h22) and its vector.
double lower_eigenvalue(const Eigen::Vector3d& h, Eigen::Vector2d* vector = nullptr) {
  const double half = 0.5 * (h[0] - h[2]);
  const double radius = std::hypot(half, h[1]);
  if (vector != nullptr) {
    const double angle = 0.5 * std::atan2(h[1], half) + 0.5 * std::acos(-1.0);
    *vector << std::cos(angle), std::sin(angle);
  }
  return 0.5 * (h[0] + h[2]) - radius;
}

double largest_entry(const Eigen::Vector3d& h) {
  return 0.5 * std::abs(h[0] + h[2]) + std::hypot(0.5 * (h[0] - h[2]), h[1]);
}

}  // namespace

ConvexityConstraints::Worst ConvexityConstraints::worst(const Eigen::VectorXd& parameters) const {
  std::vector<double> scale(static_cast<std::size_t>(term_count_), 0.0);
  std::vector<Worst> of(static_cast<std::size_t>(term_count_));
  const auto take = [&](int term, double value, double size, const std::array<double, 2>& strain) {
    const auto t = static_cast<std::size_t>(term);
    scale[t] = std::max(scale[t], size);
    if (value < of[t].smallest) of[t] = {value, 0.0, term, strain};
  };
  for (const Row& row : rows_)
    if (row.term >= 0) {
      const double value = row.by_p.dot(parameters);
      take(row.term, value, std::abs(value), {row.strain, 0.0});
    }
  for (const Matrix& matrix : matrices_) {
    const Eigen::Vector3d h = matrix.by_p * parameters + matrix.constant;
    take(matrix.term, lower_eigenvalue(h), largest_entry(h), matrix.strain);
  }
  Worst result;
  for (std::size_t t = 0; t < of.size(); ++t) {
    if (of[t].term < 0) continue;
    of[t].relative = scale[t] > 0.0 ? of[t].smallest / scale[t] : 0.0;
    if (of[t].relative < result.relative) result = of[t];
  }
  return result;
}

Eigen::VectorXd ConvexityConstraints::sizes(const Eigen::VectorXd& parameters) const {
  std::vector<double> largest(static_cast<std::size_t>(term_count_), 0.0);
  Eigen::VectorXd result = parameters.cwiseAbs();
  for (std::size_t i = 0; i < term_of_.size(); ++i)
    if (term_of_[i] >= 0) {
      double& most = largest[static_cast<std::size_t>(term_of_[i])];
      most = std::max(most, result[static_cast<Eigen::Index>(i)]);
    }
  for (std::size_t i = 0; i < term_of_.size(); ++i)
    if (term_of_[i] >= 0)
      result[static_cast<Eigen::Index>(i)] = largest[static_cast<std::size_t>(term_of_[i])];
  return result;
}

void ConvexityConstraints::add_broken(const Eigen::VectorXd& parameters,
                                      const Eigen::VectorXd& sizes, double slack,
                                      std::vector<Eigen::VectorXd>& rows,
                                      std::vector<double>& least) const {
  const auto add = [&](Eigen::VectorXd row, double at_least, double value, double size) {
    if (value - at_least >= -slack * size) return;
    for (Eigen::Index i = 0; i < row.size(); ++i)
      if (is_fixed_[static_cast<std::size_t>(i)]) {
        at_least -= row[i] * parameters[i];
        row[i] = 0.0;
      }
    if (row.cwiseAbs().maxCoeff() == 0.0) return;  // only fixed parameters could mend it
    rows.push_back(std::move(row));
    least.push_back(at_least);
  };
  for (const Row& row : rows_)
    add(row.by_p, row.least, row.by_p.dot(parameters),
        row.by_p.cwiseAbs().dot(sizes) + std::abs(row.least));
  for (const Matrix& matrix : matrices_) {
    const Eigen::Vector3d h = matrix.by_p * parameters + matrix.constant;
    Eigen::Vector2d v;
    const double value = lower_eigenvalue(h, &v);
    const Eigen::Vector3d weight(v[0] * v[0], 2.0 * v[0] * v[1], v[1] * v[1]);
    add(matrix.by_p.transpose() * weight, -matrix.constant.dot(weight),
        value - matrix.constant.dot(weight),
        (matrix.by_p.cwiseAbs() * sizes + matrix.constant.cwiseAbs()).maxCoeff());
  }
}

void ConvexityConstraints::smooth_values(const Eigen::VectorXd& parameters, Eigen::VectorXd& values,
                                         Eigen::MatrixXd* by_p) const {
  const auto rows = static_cast<Eigen::Index>(rows_.size());
  values.resize(rows + 2 * static_cast<Eigen::Index>(matrices_.size()));
  if (by_p != nullptr) by_p->resize(values.size(), parameters.size());
  Eigen::Index at = 0;
  for (const Row& row : rows_) {
    values[at] = row.by_p.dot(parameters) - row.least;
    if (by_p != nullptr) by_p->row(at) = row.by_p.transpose();
    ++at;
  }
  for (const Matrix& matrix : matrices_) {
    const Eigen::Vector3d h = matrix.by_p * parameters + matrix.constant;
    values[at] = h[0] + h[2];
    values[at + 1] = h[0] * h[2] - h[1] * h[1];
    if (by_p != nullptr) {
      by_p->row(at) = matrix.by_p.row(0) + matrix.by_p.row(2);
      by_p->row(at + 1) = Eigen::RowVector3d(h[2], -2.0 * h[1], h[0]) * matrix.by_p;
    }
    at += 2;
  }
}

}  // namespace tenter::estimation
