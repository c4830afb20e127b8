// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/torque_samples.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

namespace tenter::estimation {
namespace {

/// A piece in which gravity turns back what the cylinder bent; half a noise's width of curvature to
/// the other side is none.
bool goes_one_way(const TorqueSample& sample) {
  for (const double torque : sample.torque)
    if (torque > 0.0) return false;
  return sample.strain > -2.0 * sample.std_error;
}

ProfileSamples samples_of(const ProfileCurve& curve, const StripTest& strip, double weight,
                          int count) {
  ProfileSamples result;
  result.anchor = strip.radius_m > 0.0 ? 3.0 / strip.radius_m : 0.0;
  result.number = strip.number;
  result.noise_m = curve.noise_m();
  result.intervals = curve.intervals();
  result.curve = curve;
  result.points = strip.points;
  result.weight_N_m2 = weight;
  const Eigen::MatrixXd root = curve.covariance().llt().matrixL();
  const Eigen::Index coefficients = root.cols();
  result.strain_scatter.resize(count, coefficients);
  result.torque_scatter.resize(count * kTorquesPerSample, coefficients);
  const double width = strip.length_m / count;
  result.width_m = width;
  Eigen::Index kept = 0;
  for (int i = 0; i < count; ++i) {
    const double lo = i * width;
    const double hi = lo + width;
    TorqueSample sample;
    sample.arc_m = 0.5 * (lo + hi);
    sample.strain = 3.0 * (curve.direction(hi) - curve.direction(lo)) / width;
    const Eigen::RowVectorXd strain_scatter =
        (3.0 / width) *
        (curve.direction_by_coefficients(hi) - curve.direction_by_coefficients(lo)).transpose() *
        root;
    sample.std_error = strain_scatter.norm();
    for (int q = 0; q < kTorquesPerSample; ++q) {
      const double place = lo + (q + 0.5) / kTorquesPerSample * width;
      sample.torque[q] = curve.torque(place, weight);
      result.torque_scatter.row(kept * kTorquesPerSample + q) =
          curve.torque_by_coefficients(place, weight).transpose() * root;
    }
    if (result.anchor > 0.0 && !goes_one_way(sample)) {
      ++result.left_out;
      continue;
    }
    result.strain_scatter.row(kept) = strain_scatter;
    result.samples.push_back(sample);
    ++kept;
  }
  result.strain_scatter.conservativeResize(kept, coefficients);
  result.torque_scatter.conservativeResize(kept * kTorquesPerSample, coefficients);
  return result;
}

}  // namespace

double TorqueSample::mean_torque() const {
  double sum = 0.0;
  for (const double value : torque) sum += value;
  return sum / kTorquesPerSample;
}

Expected<std::vector<ProfileSamples>> sampled(const BendingTests& tests) {
  std::vector<ProfileSamples> all;
  std::vector<double> radii;
  for (std::size_t i = 0; i < tests.strips.size(); ++i) {
    const StripTest& strip = tests.strips[i];
    const auto curve = ProfileCurve::fitted(strip.points, {.length_m = strip.length_m});
    if (!curve) return bad_input("strip " + std::to_string(i + 1) + ": " + curve.error().message);
    all.push_back(
        samples_of(*curve, strip, tests.area_density_kg_m2 * tests.gravity_m_s2, tests.samples));
    const auto known = std::find(radii.begin(), radii.end(), strip.radius_m);
    all.back().group = static_cast<int>(known - radii.begin());
    if (known == radii.end()) radii.push_back(strip.radius_m);
  }
  return all;
}

}  // namespace tenter::estimation
