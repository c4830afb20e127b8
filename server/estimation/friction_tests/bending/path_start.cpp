// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/path_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/mechanics/laws/dahl.h"

namespace tenter::estimation {
namespace {

constexpr int kUnknowns = 4;

/// Stress after going from flat to the anchor and on to the strain, of a or b alone.
double along(const double* parameters, double anchor, double strain) {
  const double there = mechanics::dahl_step(0.0, 0.0, anchor, parameters).stress;
  return mechanics::dahl_step(anchor, there, strain, parameters).stress;
}

struct Candidate {
  double residual = 0.0;
  FrictionValues values;
};

Candidate at_tau(const std::vector<ProfileSamples>& profiles, double tau, double scale) {
  BoundedLeastSquares problem(kUnknowns);
  const double only_a[4] = {1.0, 0.0, 0.0, tau};
  const double only_b[4] = {0.0, 1.0, 0.0, tau};
  for (const ProfileSamples& profile : profiles) {
    const auto rows = static_cast<Eigen::Index>(profile.samples.size());
    Eigen::MatrixXd a(rows, kUnknowns);
    Eigen::VectorXd b(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const TorqueSample& sample = profile.samples[static_cast<std::size_t>(i)];
      a(i, 0) = scale * sample.strain;
      a(i, 1) = sample.strain * std::abs(sample.strain);
      a(i, 2) = scale * scale * along(only_a, profile.anchor, sample.strain);
      a(i, 3) = scale * along(only_b, profile.anchor, sample.strain);
      b[i] = scale * scale * sample.mean_torque();
    }
    problem.add(a, b);
  }
  const BoundedSolution found =
      problem.solve(Eigen::Vector4d::Zero(), Eigen::Vector4d::Constant(kNoBound));
  // unknowns are in units in which the columns are alike: k2 as it is, k1 and b over one scale
  const double unit = 1.0 / (scale * scale);
  return {
      found.residual,
      {found.x[0] * scale * unit, found.x[1] * unit, found.x[2], found.x[3] * scale * unit, tau}};
}

}  // namespace

std::vector<FrictionValues> path_starts(const std::vector<ProfileSamples>& profiles) {
  double largest = 0.0;
  for (const ProfileSamples& profile : profiles) {
    largest = std::max(largest, profile.anchor);
    for (const TorqueSample& sample : profile.samples)
      largest = std::max(largest, std::abs(sample.strain));
  }
  if (!(largest > 0.0)) return {};
  std::vector<Candidate> candidates;
  constexpr int kValues = 40;
  candidates.reserve(kValues);
  for (int i = 0; i < kValues; ++i)
    candidates.push_back(
        at_tau(profiles, largest * 1e-3 * std::pow(1e3, i / (kValues - 1.0)), largest));
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& one, const auto& other) {
    return one.residual < other.residual;
  });
  std::vector<FrictionValues> starts;
  for (const std::size_t i : {0, 3, 8}) starts.push_back(candidates[i].values);
  return starts;
}

}  // namespace tenter::estimation
