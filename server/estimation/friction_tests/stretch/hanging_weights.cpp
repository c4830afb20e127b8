// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/stretch/hanging_weights.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "server/estimation/friction_tests/stretch/length_errors.h"

namespace tenter::estimation {
namespace {

/// Of one reading, from the residuals of a fit that took it for `sigma`.
double noise_of(const FitResult& fit, double sigma) {
  const auto rows = static_cast<double>(fit.residuals.size());
  return sigma * std::sqrt(fit.chi2 / std::max(1.0, rows - 5.0));
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
  const MakeFunction make = [&] { return std::make_unique<LengthErrors>(*point, *checked); };
  judge(make, model, options, estimate);
  return estimate;
}

}  // namespace tenter::estimation
