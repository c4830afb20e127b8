// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/cantilever/moment_errors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace tenter::estimation {

MomentErrors::MomentErrors(StrainPoint point,
                           std::shared_ptr<const std::vector<ProfileSamples>> profiles,
                           const Eigen::VectorXd& parameters)
    : point_(std::move(point)), profiles_(std::move(profiles)) {
  int frame = 0;
  int block = 0;
  for (const ProfileSamples& profile : *profiles_) {
    for (std::size_t i = 0; i < profile.samples.size(); ++i)
      rows_.push_back({0, 0, frame++, block});
    ++block;
  }
  set_reference(parameters);
}

void MomentErrors::set_reference(const Eigen::VectorXd& parameters) {
  factors_.clear();
  for (const ProfileSamples& profile : *profiles_) {
    Eigen::MatrixXd scatter(profile.strain_scatter.rows(), profile.strain_scatter.cols());
    for (Eigen::Index i = 0; i < scatter.rows(); ++i) {
      point_.begin(walk_);
      double load = 0.0;
      double tangent = 0.0;
      point_.look(profile.samples[static_cast<std::size_t>(i)].strain, parameters, false, walk_,
                  load, tangent);
      scatter.row(i) = profile.torque_scatter.middleRows(i * kTorquesPerSample, kTorquesPerSample)
                           .colwise()
                           .mean() -
                       tangent * profile.strain_scatter.row(i);
    }
    Eigen::MatrixXd covariance = scatter * scatter.transpose();
    // fewer coefficients than samples leave some combinations without scatter
    const double least = 1e-6 * covariance.trace() /
                         static_cast<double>(std::max<Eigen::Index>(1, covariance.rows()));
    covariance.diagonal().array() += least;
    factors_.emplace_back(covariance.llt().matrixL());
  }
}

mechanics::PathStatus MomentErrors::evaluate(const Eigen::VectorXd& parameters,
                                             Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  residuals.resize(count);
  if (jacobian != nullptr) jacobian->resize(count, parameter_count());
  Eigen::Index row = 0;
  for (std::size_t p = 0; p < profiles_->size(); ++p) {
    const ProfileSamples& profile = (*profiles_)[p];
    const Eigen::Index first = row;
    for (const TorqueSample& sample : profile.samples) {
      point_.begin(walk_);
      double load = 0.0;
      double tangent = 0.0;
      point_.look(sample.strain, parameters, jacobian != nullptr, walk_, load, tangent);
      residuals[row] = load - sample.mean_torque();
      if (jacobian != nullptr) jacobian->row(row) = walk_.load_by_p.transpose();
      ++row;
    }
    const auto factor = factors_[p].triangularView<Eigen::Lower>();
    factor.solveInPlace(residuals.segment(first, row - first));
    if (jacobian != nullptr) {
      Eigen::MatrixXd block = jacobian->middleRows(first, row - first);
      factor.solveInPlace(block);
      jacobian->middleRows(first, row - first) = block;
    }
  }
  return residuals.allFinite() ? mechanics::PathStatus::ok : mechanics::PathStatus::not_finite;
}

}  // namespace tenter::estimation
