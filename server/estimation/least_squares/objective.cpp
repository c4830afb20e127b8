// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/objective.h"

#include <Eigen/QR>
#include <cmath>
#include <utility>

namespace tenter::estimation {
namespace {

constexpr Eigen::Index kBatch = 128;  // rows: R and a batch stay in the cache

}  // namespace

LossValue loss_at(const RobustLoss& loss, double s) {
  const double a = loss.scale;
  switch (loss.kind) {
    case Loss::huber: {
      if (s <= a * a) break;
      const double root = std::sqrt(s);
      return {2.0 * a * root - a * a, a / root, -0.5 * a / (s * root)};
    }
    case Loss::cauchy: {
      const double part = 1.0 + s / (a * a);
      return {a * a * std::log1p(s / (a * a)), 1.0 / part, -1.0 / (a * a * part * part)};
    }
    case Loss::none:
      break;
  }
  return {s, 1.0, 0.0};
}

Objective::Objective(ResidualFunction& evaluator, Eigen::VectorXd& all, std::vector<int> free,
                     Eigen::VectorXd scale, const Eigen::VectorXd& weights, const RobustLoss& loss)
    : evaluator_(evaluator),
      all_(all),
      free_(std::move(free)),
      scale_(std::move(scale)),
      weights_(weights),
      loss_(loss) {
  batch_.resize(row_count() + kBatch, row_count());
}

Objective Objective::with_free(const std::vector<int>& kept) const {
  std::vector<int> free;
  Eigen::VectorXd scale(static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k) {
    free.push_back(free_[static_cast<std::size_t>(kept[k])]);
    scale[static_cast<Eigen::Index>(k)] = scale_[kept[k]];
  }
  return {evaluator_, all_, std::move(free), std::move(scale), weights_, loss_};
}

bool Objective::evaluate(const double* x, double* residuals, double* jacobian) {
  for (std::size_t i = 0; i < free_.size(); ++i)
    all_[free_[i]] = x[i] * scale_[static_cast<Eigen::Index>(i)];
  if (evaluator_.evaluate(all_, r_, jacobian ? &j_ : nullptr) != mechanics::PathStatus::ok)
    return false;
  Eigen::Map<Eigen::VectorXd> out(residuals, row_count());
  if (!jacobian) {
    double cost = 0.0;
    for (Eigen::Index k = 0; k < r_.size(); ++k)
      if (weights_[k] > 0.0) cost += weights_[k] * loss_at(loss_, r_[k] * r_[k]).rho;
    out.setZero();
    out[0] = std::sqrt(cost);
    return std::isfinite(cost);
  }
  compress();
  const Eigen::Index n = parameter_count();
  out = batch_.col(n).head(n + 1);
  Eigen::Map<RowMatrix> out_j(jacobian, n + 1, n);
  out_j = batch_.topLeftCorner(n + 1, n);
  return out.allFinite() && out_j.allFinite();
}

/// Leaves R of [J f] in the upper rows of batch_.
///
///   f = r sqrt(w rho/s)      df/dr = rho' sqrt(w s/rho)       s = r^2
void Objective::compress() {
  const Eigen::Index n = parameter_count();
  batch_.setZero();
  Eigen::Index filled = 0;
  const auto reduce = [&] {
    if (filled == 0) return;
    batch_.middleRows(n + 1 + filled, kBatch - filled).setZero();
    Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(batch_);
    for (Eigen::Index c = 0; c <= n; ++c) batch_.col(c).tail(batch_.rows() - c - 1).setZero();
    filled = 0;
  };
  for (Eigen::Index k = 0; k < r_.size(); ++k) {
    if (!(weights_[k] > 0.0)) continue;
    const double s = r_[k] * r_[k];
    const LossValue loss = loss_at(loss_, s);
    const double part = s > 0.0 ? std::sqrt(loss.rho / s) : 1.0;
    const double root = std::sqrt(weights_[k]);
    const double slope = root * loss.by_s / part;
    const Eigen::Index row = n + 1 + filled;
    for (Eigen::Index c = 0; c < n; ++c)
      batch_(row, c) = slope * j_(k, free_[static_cast<std::size_t>(c)]) * scale_[c];
    batch_(row, n) = root * part * r_[k];
    if (++filled == kBatch) reduce();
  }
  reduce();
}

}  // namespace tenter::estimation
