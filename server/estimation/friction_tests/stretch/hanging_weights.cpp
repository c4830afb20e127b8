// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/stretch/hanging_weights.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>

#include "server/estimation/friction_tests/stretch/length_errors.h"

namespace tenter::estimation {
namespace {

/// Of one reading, from the residuals of a fit that took it for `sigma`.
double noise_of(const FitResult& fit, double sigma) {
  const auto rows = static_cast<double>(fit.residuals.size());
  return sigma * std::sqrt(fit.chi2 / std::max(1.0, rows - 5.0));
}

/// Why some of the five may not be told.
std::vector<ReadingsLack> lacks_of(const WeightTable& table) {
  std::vector<ReadingsLack> lacks;
  const auto places = places_of(table);
  const auto has = [&](double sign) {
    return std::any_of(places.begin(), places.end(),
                       [sign](const ReadingPlace& place) { return place.sign == sign; });
  };
  std::set<double> weights;
  for (const WeightReading& reading : table.readings) weights.insert(reading.weight_N);
  constexpr std::size_t kFewest = 4;  // a straight line, and what bends it in two ways
  if (weights.size() < kFewest)
    lacks.push_back({{"k1", "k2", "a", "b", "tau"},
                     "only " + std::to_string(weights.size()) +
                         " different weights were hung, too few for five numbers"});
  if (!has(-1.0))
    lacks.push_back({{"k1", "k2", "a", "b", "tau"},
                     "no weight was taken off again: on one way friction looks like stiffness"});
  if (!has(1.0))
    lacks.push_back({{"k1", "k2", "a", "b", "tau"},
                     "no weight was added: on one way friction looks like stiffness"});
  return lacks;
}

}  // namespace

Expected<FrictionEstimate> fit_hanging_weights(const WeightTable& table, std::string_view measure,
                                               const FrictionFitOptions& options) {
  if (measure != "green_u" && measure != "green_v")
    return bad_input("hanging weights stretch: \"" + std::string(measure) +
                     "\" is neither green_u nor green_v");
  Expected<WeightTable> checked = check(table);
  if (!checked) return tl::unexpected(checked.error());
  const model::Model model = friction_model(measure);
  const Expected<StrainPoint> point = StrainPoint::make(model);
  if (!point) return tl::unexpected(point.error());

  FrictionEstimate estimate;
  AnchoredErrors anchored(anchored_readings(*checked), 1.0);
  estimate.start = anchored_start(anchored, model, nullptr);

  const std::vector<FrictionValues> starts = starts_of(estimate.start, anchored);
  const bool noise_is_given = checked->length_noise_m > 0.0;
  if (!noise_is_given) checked->length_noise_m = 1e-4;
  const auto fitted = [&] {
    LengthErrors errors(*point, *checked);
    FitResult found = fit_from(starts, errors, model, options.fit);
    estimate.snapped = errors.snapped();
    return found;
  };
  estimate.fit = fitted();
  if (!estimate.fit.usable)
    return bad_input("hanging weights: no start of the fit finds the cloth at rest");
  if (!noise_is_given) {
    checked->length_noise_m =
        std::max(noise_of(estimate.fit, checked->length_noise_m), 1e-9 * checked->rest_length_m);
    estimate.fit = fitted();
  }
  estimate.noise = checked->length_noise_m;
  estimate.lacks = lacks_of(*checked);
  const MakeFunction make = [&] { return std::make_unique<LengthErrors>(*point, *checked); };
  judge(make, model, options, estimate);
  return estimate;
}

}  // namespace tenter::estimation
