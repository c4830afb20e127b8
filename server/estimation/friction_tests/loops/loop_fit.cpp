// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/loops/loop_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "server/estimation/friction_tests/loops/load_errors.h"

namespace tenter::estimation {
namespace {

double rms_of_loads(const LoopTable& table) {
  double squares = 0.0;
  for (const LoopReading& reading : table.readings) squares += reading.load * reading.load;
  return std::sqrt(squares / static_cast<double>(table.readings.size()));
}

/// The readings as the model has them.
LoopTable predicted_loops(const LoopTable& table, const FitResult& fit) {
  LoopTable model = table;
  for (std::size_t i = 0; i < model.readings.size(); ++i)
    model.readings[i].load += table.load_noise * fit.residuals[static_cast<Eigen::Index>(i)];
  return model;
}

}  // namespace

Expected<LoopEstimate> fit_loops(const LoopTable& table, std::string_view measure,
                                 const FrictionFitOptions& options) {
  if (measure != "green_u" && measure != "green_v")
    return bad_input("loops stretch: \"" + std::string(measure) +
                     "\" is neither green_u nor green_v");
  Expected<LoopTable> checked = check(table);
  if (!checked) return tl::unexpected(checked.error());
  const double size = rms_of_loads(*checked);
  if (!(size > 0.0)) return bad_input("all loads are zero");
  const model::Model model = friction_model(measure);
  const Expected<StrainPoint> point = StrainPoint::make(model);
  if (!point) return tl::unexpected(point.error());

  LoopEstimate estimate;
  FrictionEstimate& friction = estimate.friction;
  AnchoredErrors anchored(anchored_readings(*checked), 1.0);
  if (anchored.row_count() < static_cast<int>(kFrictionParameters))
    return bad_input("loops: " + std::to_string(anchored.row_count()) +
                     " readings come after a turn of the strain: too few");
  friction.start = anchored_start(anchored, model, nullptr);
  const std::vector<FrictionValues> starts = starts_of(friction.start, anchored);

  const double given = checked->load_noise;
  const auto fitted = [&](double noise) {
    checked->load_noise = noise;
    LoadErrors errors(*point, *checked);
    return fit_from(starts, errors, model, options.fit);
  };
  friction.fit = fitted(given > 0.0 ? given : 0.01 * size);
  if (!friction.fit.usable) return bad_input("loops: " + friction.fit.message);
  const auto rows = static_cast<double>(friction.fit.residuals.size());
  const double left = checked->load_noise * std::sqrt(friction.fit.chi2 / std::max(1.0, rows - 5));
  // a model that is right leaves its noise and no more
  constexpr double kMore = 1.2;
  estimate.noise_is_from_fit = !(given > 0.0) || left > kMore * given;
  if (estimate.noise_is_from_fit) {
    friction.fit = fitted(std::max(left, 1e-9 * size));
    if (!friction.fit.usable) return bad_input("loops: " + friction.fit.message);
  }
  friction.noise = checked->load_noise;
  estimate.missed_share =
      friction.noise * std::sqrt(friction.fit.residuals.squaredNorm() / rows) / size;
  estimate.lost_share = lost_share(*checked);
  estimate.lost_share_of_model = lost_share(predicted_loops(*checked, friction.fit));
  const MakeFunction make = [&] { return std::make_unique<LoadErrors>(*point, *checked); };
  judge(make, model, options, friction);
  return estimate;
}

}  // namespace tenter::estimation
