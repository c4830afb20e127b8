// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/bending_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "server/estimation/friction_tests/bending/cantilever/moment_errors.h"
#include "server/estimation/friction_tests/bending/contour/contour_errors.h"
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

using SharedProfiles = std::shared_ptr<const std::vector<ProfileSamples>>;

/// Strips of one radius one after the other: the rows of a block have to be neighbours.
void sort_by_group(BendingTests& tests) {
  std::stable_sort(tests.strips.begin(), tests.strips.end(),
                   [](const StripTest& a, const StripTest& b) { return a.radius_m < b.radius_m; });
}

Expected<void> check_measure(std::string_view measure) {
  if (measure == "bend_u" || measure == "bend_v") return {};
  return bad_input("spirals and cantilevers bend: \"" + std::string(measure) +
                   "\" is neither bend_u nor bend_v");
}

Expected<SharedProfiles> profiles_of(BendingTests tests, BendingProtocol protocol) {
  Expected<BendingTests> checked = check(std::move(tests), protocol);
  if (!checked) return tl::unexpected(checked.error());
  sort_by_group(*checked);
  auto profiles = sampled(*checked);
  if (!profiles) return tl::unexpected(profiles.error());
  return std::make_shared<const std::vector<ProfileSamples>>(std::move(*profiles));
}

/// Why some of the five may not be told.
std::vector<ReadingsLack> lacks_of(const std::vector<ProfileSamples>& profiles) {
  std::vector<ReadingsLack> lacks;
  std::set<double> anchors;
  bool has_cantilever = false;
  for (const ProfileSamples& profile : profiles) {
    has_cantilever = has_cantilever || profile.anchor == 0.0;
    if (profile.anchor > 0.0 && !profile.samples.empty()) anchors.insert(profile.anchor);
  }
  constexpr std::size_t kFewest = 3;
  if (anchors.size() < kFewest)
    lacks.push_back({{"k2", "a", "b", "tau"},
                     "the spirals are of " + std::to_string(anchors.size()) +
                         (anchors.size() == 1 ? " radius" : " radii") +
                         " only: friction is seen at too few curvatures"});
  if (!has_cantilever)
    lacks.push_back({{"k1", "k2"},
                     "there is no cantilever: light spirals show stiffness beside friction only"});
  return lacks;
}

double mean_noise(const std::vector<ProfileSamples>& profiles) {
  double noise = 0.0;
  for (const ProfileSamples& profile : profiles) noise += profile.noise_m;
  return noise / static_cast<double>(profiles.size());
}

/// From torques and curvatures as they were read (torque_errors.h), whose scatter depends on the
/// model: near enough for the shapes, which far from what was seen hardly lead a fit.
std::vector<FrictionValues> torque_start(TorqueErrors& errors, const model::Model& model,
                                         std::vector<FrictionValues> starts,
                                         const FitOptions& options) {
  // until there is a fit to take it from, the torques' scatter is that of the best start
  if (errors.set_reference(flat(starts.front())) != mechanics::PathStatus::ok)
    starts.erase(starts.begin());
  FitResult found = fit_from(starts, errors, model, options);
  if (!found.usable) return starts;
  const Eigen::VectorXd reference = found.parameters;
  if (errors.set_reference(reference) == mechanics::PathStatus::ok)
    if (FitResult again = fit(errors, with_values(model, values_of(reference)), options);
        again.usable)
      found = std::move(again);
  return {values_of(found.parameters)};
}

/// Where a strip stands at the edge of a snap it may find no rest at all: a little beside it does.
std::vector<FrictionValues> beside_of(const FrictionValues& start) {
  std::vector<FrictionValues> beside;
  for (const double more : {1.01, 0.99, 1.03, 0.97}) {
    FrictionValues values = start;
    values.k1 *= more;
    beside.push_back(values);
    values = start;
    values.b *= more;
    beside.push_back(values);
  }
  return beside;
}

/// The best of the starts after a few steps each; not usable where none finds the strips at rest.
FitResult best_of(ContourErrors& errors, const model::Model& model,
                  const std::vector<FrictionValues>& starts, const FitOptions& few) {
  FitResult best;
  for (const FrictionValues& from : starts) {
    if (errors.set_reference(flat(from)) != mechanics::PathStatus::ok) continue;
    FitResult found = fit(errors, with_values(model, from), few);
    if (found.usable && (!best.usable || found.chi2 < best.chi2)) best = std::move(found);
  }
  return best;
}

/// The best of the starts, or of the `others` where none of them finds the strips at rest, a few
/// steps at a time. Where the strips stand is taken out near where they stand at a reference, which
/// the fit moves: until it moves it no more.
Expected<FitResult> fit_shapes(ContourErrors& errors, const model::Model& model,
                               const std::vector<FrictionValues>& starts,
                               const std::vector<FrictionValues>& others,
                               const FitOptions& options) {
  constexpr int kMaxRounds = 40;
  constexpr double kStill = 2e-5;  // of the cost: a tenth of what one noise counts, of 5000 rows
  FitOptions few = options;
  few.max_iterations = std::min(options.max_iterations, 5);
  FitResult best = best_of(errors, model, starts, few);
  if (!best.usable) best = best_of(errors, model, others, few);
  if (!best.usable) return bad_input("strips: no start of the fit finds them at rest");
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::VectorXd reference = best.parameters;
    const double before = best.chi2;
    if (errors.set_reference(reference) != mechanics::PathStatus::ok)
      return bad_input("strips: the model finds no rest under their weight");
    best = fit(errors, with_values(model, values_of(reference)), few);
    if (!best.usable) return bad_input("strips: " + best.message);
    if (std::abs(before - best.chi2) <= kStill * best.chi2) break;
  }
  return best;
}

/// The fit from its starts, and what is known of each number.
Expected<void> finish(ContourErrors& errors, const std::vector<ProfileSamples>& shared,
                      const model::Model& model, const std::vector<FrictionValues>& starts,
                      const std::vector<FrictionValues>& others, const FrictionFitOptions& options,
                      BendingEstimate& estimate) {
  FrictionEstimate& friction = estimate.friction;
  auto found = fit_shapes(errors, model, starts, others, options.fit);
  if (!found) return tl::unexpected(found.error());
  friction.fit = std::move(*found);
  friction.snapped = errors.snapped();
  estimate.predicted = errors.predicted();
  friction.noise = mean_noise(shared);
  friction.lacks = lacks_of(shared);
  const MakeFunction make = [&] { return std::make_unique<ContourErrors>(errors); };
  // refits of a profile start next to where they end
  FrictionFitOptions near = options;
  near.fit.max_iterations = std::min(options.fit.max_iterations, 8);
  judge(make, model, near, friction);
  return {};
}

}  // namespace

Expected<BendingEstimate> fit_bending(const BendingTests& tests, std::string_view measure,
                                      const FrictionFitOptions& options) {
  if (auto ok = check_measure(measure); !ok) return tl::unexpected(ok.error());
  const auto profiles = profiles_of(tests, BendingProtocol::spirals);
  if (!profiles) return tl::unexpected(profiles.error());
  const SharedProfiles& shared = *profiles;

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
  AnchoredStart& start = estimate.friction.start;
  start = anchored_start(anchored, model, has_cantilever ? &estimate.cantilever : nullptr);
  for (double& rms : start.rms_load) rms *= kTorqueUnit;

  TorqueErrors torques(*point, shared);
  ContourErrors errors(*point, shared);
  std::vector<FrictionValues> starts = path_starts(*shared);
  starts.push_back(start.stages.back());
  starts = torque_start(torques, model, std::move(starts), options.fit);
  const std::vector<FrictionValues> beside = beside_of(starts.front());
  if (auto done = finish(errors, *shared, model, starts, beside, options, estimate); !done)
    return tl::unexpected(done.error());
  return estimate;
}

Expected<BendingEstimate> fit_cantilevers(const BendingTests& tests, std::string_view measure,
                                          const FrictionFitOptions& options) {
  if (auto ok = check_measure(measure); !ok) return tl::unexpected(ok.error());
  const auto profiles = profiles_of(tests, BendingProtocol::cantilevers);
  if (!profiles) return tl::unexpected(profiles.error());
  const SharedProfiles& shared = *profiles;

  BendingEstimate estimate;
  estimate.profiles = *shared;
  estimate.cantilever = stiffness_of_cantilevers(*shared);
  if (!(estimate.cantilever.k1 > 0.0))
    return bad_input("cantilevers: their weight does not bend them, so that no stiffness is seen");
  FrictionValues start = estimate.cantilever;
  start.tau = 1.0;
  model::Model model = with_values(friction_model(measure), start);
  for (model::Parameter& p : model.terms.back().law.parameters) p.fixed = true;
  const auto point = StrainPoint::make(model);
  if (!point) return tl::unexpected(point.error());
  FrictionEstimate& friction = estimate.friction;
  Eigen::VectorXd reference = flat(start);
  for (int round = 0; round < 3; ++round) {
    MomentErrors errors(*point, shared, reference);
    FitResult again = fit(errors, with_values(model, values_of(reference)), options.fit);
    if (!again.usable) return bad_input("cantilevers: " + again.message);
    friction.fit = std::move(again);
    if (round < 2) reference = friction.fit.parameters;
  }
  friction.noise = mean_noise(*shared);
  const MakeFunction make = [&] {
    return std::make_unique<MomentErrors>(*point, shared, reference);
  };
  judge(make, model, options, friction);
  for (FrictionNumber& number : estimate.friction.numbers) {
    if (number.name == "k1" || number.name == "k2") continue;
    number.is_told = false;
    number.words = "not told: a strip that was never rolled goes one way";
  }
  return estimate;
}

}  // namespace tenter::estimation
