// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/bending_fit.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "server/estimation/friction_tests/bending/path_start.h"
#include "server/estimation/friction_tests/bending/torque_errors.h"
#include "server/estimation/least_squares/bounded_least_squares.h"

namespace tenter::estimation {
namespace {

/// M = (k1 + k2 eps) eps over all samples of the cantilevers.
FrictionValues stiffness_of_cantilevers(const std::vector<ProfileSamples>& profiles) {
  std::vector<const TorqueSample*> samples;
  for (const ProfileSamples& profile : profiles)
    if (profile.anchor == 0.0)
      for (const TorqueSample& sample : profile.samples) samples.push_back(&sample);
  FrictionValues values;
  if (samples.size() < 2) return values;
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd a(rows, 2);
  Eigen::VectorXd b(rows);
  double scale = 0.0;  // k2 in units of k1 / eps
  for (const TorqueSample* sample : samples) scale = std::max(scale, sample->strain);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const TorqueSample& sample = *samples[static_cast<std::size_t>(i)];
    a(i, 0) = sample.strain;
    a(i, 1) = sample.strain * sample.strain / scale;
    b[i] = sample.mean_torque();
  }
  BoundedLeastSquares problem(2);
  problem.add(a, b);
  const BoundedSolution found =
      problem.solve(Eigen::Vector2d(0.0, -kNoBound), Eigen::Vector2d(kNoBound, kNoBound));
  values.k1 = found.x[0];
  values.k2 = found.x[1] / scale;
  return values;
}

std::vector<AnchoredReading> anchored_readings(const std::vector<ProfileSamples>& profiles) {
  std::vector<AnchoredReading> readings;
  for (const ProfileSamples& profile : profiles) {
    if (profile.anchor == 0.0) continue;
    for (const TorqueSample& sample : profile.samples) {
      AnchoredReading reading;
      reading.load = sample.mean_torque();
      reading.strain = sample.strain;
      reading.anchor = profile.anchor;
      reading.sign = -1.0;
      reading.block = profile.group;
      readings.push_back(reading);
    }
  }
  return readings;
}

/// Strips of one radius one after the other: the rows of a block have to be neighbours.
void sort_by_group(BendingTests& tests) {
  std::stable_sort(tests.strips.begin(), tests.strips.end(),
                   [](const StripTest& a, const StripTest& b) { return a.radius_m < b.radius_m; });
}

}  // namespace

Expected<BendingEstimate> fit_bending(const BendingTests& tests, std::string_view measure,
                                      const FrictionFitOptions& options) {
  if (measure != "bend_u" && measure != "bend_v")
    return bad_input("spirals and cantilevers bend: \"" + std::string(measure) +
                     "\" is neither bend_u nor bend_v");
  Expected<BendingTests> checked = check(tests);
  if (!checked) return tl::unexpected(checked.error());
  sort_by_group(*checked);
  auto profiles = sampled(*checked);
  if (!profiles) return tl::unexpected(profiles.error());
  const auto shared = std::make_shared<const std::vector<ProfileSamples>>(std::move(*profiles));

  BendingEstimate estimate;
  estimate.profiles = *shared;
  for (const ProfileSamples& profile : *shared) estimate.left_out += profile.left_out;
  const std::vector<AnchoredReading> readings = anchored_readings(*shared);
  if (readings.size() < 5)
    return bad_input("of the spirals " + std::to_string(readings.size()) +
                     " samples are left, and " + std::to_string(estimate.left_out) +
                     " taken out where gravity and elasticity oppose: too few");
  const model::Model model = friction_model(measure);
  const auto point = StrainPoint::make(model);
  if (!point) return tl::unexpected(point.error());
  estimate.cantilever = stiffness_of_cantilevers(*shared);
  const bool has_cantilever = estimate.cantilever.k1 > 0.0;
  // torques are of the order of 1e-3 N: in units of that
  constexpr double kTorqueUnit = 1e-4;
  AnchoredErrors anchored(readings, kTorqueUnit);
  FrictionEstimate& friction = estimate.friction;
  friction.start = anchored_start(anchored, model, has_cantilever ? &estimate.cantilever : nullptr);
  for (double& rms : friction.start.rms_load) rms *= kTorqueUnit;

  TorqueErrors errors(*point, shared);
  std::vector<FrictionValues> starts = path_starts(*shared);
  starts.push_back(friction.start.stages.back());
  // until there is a fit to take it from, the torques' scatter is that of the best start
  if (errors.set_reference(flat(starts.front())) != mechanics::PathStatus::ok)
    starts.erase(starts.begin());
  friction.fit = fit_from(starts, errors, model, options.fit);
  if (!friction.fit.usable)
    return bad_input("spirals: no start of the fit finds the strips at rest");
  // the scatter that the torques' errors add depends on the model: twice is enough
  Eigen::VectorXd reference;
  for (int round = 0; round < 2; ++round) {
    reference = friction.fit.parameters;
    if (errors.set_reference(reference) != mechanics::PathStatus::ok)
      return bad_input("spirals: the model finds no rest under the weight of the strips");
    FitResult again = fit(errors, with_values(model, values_of(reference)), options.fit);
    if (!again.usable) return bad_input("spirals: " + again.message);
    friction.fit = std::move(again);
  }
  friction.snapped = errors.snapped();
  estimate.predicted.assign(errors.predicted().data(),
                            errors.predicted().data() + errors.predicted().size());
  double noise = 0.0;
  for (const ProfileSamples& profile : *shared) noise += profile.noise_m;
  friction.noise = noise / static_cast<double>(shared->size());
  const MakeFunction make = [&]() -> std::unique_ptr<ResidualFunction> {
    auto own = std::make_unique<TorqueErrors>(*point, shared);
    if (own->set_reference(reference) != mechanics::PathStatus::ok) return nullptr;
    return own;
  };
  judge(make, model, options, friction);
  return estimate;
}

}  // namespace tenter::estimation
