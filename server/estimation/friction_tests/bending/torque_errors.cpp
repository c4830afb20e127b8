// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/torque_errors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::estimation {

using mechanics::PathStatus;

TorqueErrors::TorqueErrors(StrainPoint point,
                           std::shared_ptr<const std::vector<ProfileSamples>> profiles)
    : point_(std::move(point)), profiles_(std::move(profiles)) {
  // strips of one radius follow each other as one block
  int frame = 0;
  for (std::size_t i = 0; i < profiles_->size(); ++i)
    for (std::size_t k = 0; k < (*profiles_)[i].samples.size(); ++k)
      rows_.push_back({0, 0, frame++, (*profiles_)[i].group});
  for (const ProfileSamples& profile : *profiles_) {
    const Eigen::MatrixXd covariance = profile.strain_scatter * profile.strain_scatter.transpose();
    factors_.emplace_back(covariance.llt().matrixL());
  }
}

void TorqueErrors::read_torques(std::size_t number) {
  const ProfileSamples& profile = (*profiles_)[number];
  torques_.resize(static_cast<Eigen::Index>(profile.samples.size()) * kTorquesPerSample);
  Eigen::Index at = 0;
  for (const TorqueSample& sample : profile.samples)
    for (const double torque : sample.torque) torques_[at++] = torque;
}

// Torques of one side of the anchor's, those next to it first: one way, walked once.
PathStatus TorqueErrors::walk_side(double anchor, const Eigen::VectorXd& parameters, bool up) {
  point_.begin(walk_);
  if (anchor != 0.0) point_.to_strain(anchor, parameters, walk_);
  const double anchor_load = walk_.load;
  order_.clear();
  for (int i = 0; i < static_cast<int>(torques_.size()); ++i)
    if ((torques_[i] > anchor_load) == up) order_.push_back(i);
  std::sort(order_.begin(), order_.end(), [&](int a, int b) {
    return up ? torques_[a] < torques_[b] : torques_[a] > torques_[b];
  });
  for (const int i : order_) {
    const PathStatus status = point_.to_load(torques_[i], parameters, walk_);
    if (status != PathStatus::ok) return status;
    strains_[i] = walk_.strain;
    strains_by_p_.row(i) = walk_.strain_by_p.transpose();
  }
  return PathStatus::ok;
}

PathStatus TorqueErrors::predict(double anchor, const Eigen::VectorXd& parameters) {
  strains_.resize(torques_.size());
  strains_by_p_.resize(torques_.size(), parameter_count());
  const PathStatus status = walk_side(anchor, parameters, false);
  return status == PathStatus::ok ? walk_side(anchor, parameters, true) : status;
}

PathStatus TorqueErrors::set_reference(const Eigen::VectorXd& parameters) {
  std::vector<Eigen::MatrixXd> factors = factors_;
  for (std::size_t i = 0; i < profiles_->size(); ++i) {
    const ProfileSamples& profile = (*profiles_)[i];
    read_torques(i);
    const Eigen::VectorXd errors = profile.torque_scatter.rowwise().norm();
    const Eigen::VectorXd torques = torques_;
    torques_ = torques - errors;
    PathStatus status = predict(profile.anchor, parameters);
    if (status != PathStatus::ok) return status;
    const Eigen::VectorXd below = strains_;
    torques_ = torques + errors;
    status = predict(profile.anchor, parameters);
    if (status != PathStatus::ok) return status;
    const Eigen::VectorXd above = strains_;
    torques_ = torques;
    status = predict(profile.anchor, parameters);
    if (status != PathStatus::ok) return status;
    const Eigen::VectorXd compliances = (above - below).cwiseQuotient(2.0 * errors);
    const Eigen::VectorXd bends = (above - 2.0 * strains_ + below).cwiseAbs();
    Eigen::MatrixXd scatter = -profile.strain_scatter;
    for (Eigen::Index k = 0; k < scatter.rows(); ++k)
      for (Eigen::Index q = 0; q < kTorquesPerSample; ++q) {
        const Eigen::Index at = k * kTorquesPerSample + q;
        scatter.row(k) += (compliances[at] / kTorquesPerSample) * profile.torque_scatter.row(at);
      }
    Eigen::MatrixXd covariance = scatter * scatter.transpose();
    // what is not linear in the errors, as beside a snap, says nothing of the neighbours
    for (Eigen::Index k = 0; k < scatter.rows(); ++k) {
      const double bend = bends.segment(k * kTorquesPerSample, kTorquesPerSample).mean();
      covariance(k, k) += bend * bend;
    }
    factors[i] = covariance.llt().matrixL();
  }
  factors_ = std::move(factors);
  return PathStatus::ok;
}

PathStatus TorqueErrors::evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals,
                                  RowMatrix* jacobian) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  residuals.resize(count);
  if (jacobian != nullptr) jacobian->resize(count, parameter_count());
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < profiles_->size(); ++i) {
    const ProfileSamples& profile = (*profiles_)[i];
    const auto rows = static_cast<Eigen::Index>(profile.samples.size());
    if (rows == 0) continue;
    read_torques(i);
    const PathStatus status = predict(profile.anchor, parameters);
    if (status != PathStatus::ok) return status;
    block_.setZero(rows, parameter_count());
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto places = strains_.segment(k * kTorquesPerSample, kTorquesPerSample);
      residuals[first + k] = places.mean() - profile.samples[static_cast<std::size_t>(k)].strain;
      block_.row(k) =
          strains_by_p_.middleRows(k * kTorquesPerSample, kTorquesPerSample).colwise().mean();
    }
    const auto factor = factors_[i].triangularView<Eigen::Lower>();
    factor.solveInPlace(residuals.segment(first, rows));
    if (jacobian != nullptr) {
      factor.solveInPlace(block_);
      jacobian->middleRows(first, rows) = block_;
    }
    first += rows;
  }
  return residuals.allFinite() ? PathStatus::ok : PathStatus::not_finite;
}

}  // namespace tenter::estimation
