// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/at_rest.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tenter::diagnosis {
namespace {

/// Imposed strains within a two-hundredth of what the curves reach.
bool rests(const estimation::Curves& curves, int frame) {
  constexpr double kStill = 0.005;
  const mechanics::StrainPath& path = curves.path;
  if (frame > 0 && path.start[static_cast<std::size_t>(frame)] != mechanics::FrameStart::virgin)
    return false;
  for (int i = 0; i < 3; ++i) {
    if (path.is_free[static_cast<std::size_t>(i)]) continue;
    const double rest = i < 2 ? 1.0 : 0.0;
    double reach = 0.0;
    for (const Eigen::Vector3d& q : path.q) reach = std::max(reach, std::abs(q[i] - rest));
    if (std::abs(path.q[static_cast<std::size_t>(frame)][i] - rest) > kStill * reach) return false;
  }
  return true;
}

}  // namespace

std::string objection_at_rest(const Trial& trial, const DataPointer& data) {
  constexpr double kLargest = 0.5;  // of the offset
  constexpr double kCertain = 3.0;  // standard deviations
  const std::vector<estimation::Row> rows = data->rows();
  for (const model::SensorCorrection& added : trial.variant.corrections) {
    const auto c =
        std::ranges::find(trial.model.corrections, added.id, &model::SensorCorrection::id);
    if (added.type != "offset" || c == trial.model.corrections.end()) continue;
    double missed = 0.0, variance = 0.0, count = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const estimation::Curves& curves = data->curves[static_cast<std::size_t>(rows[r].curve)];
      const estimation::ObservedChannel& channel =
          curves.channels[static_cast<std::size_t>(rows[r].channel)];
      const bool is_its = channel.is_stress &&
                          estimation::component_name(channel.component) == c->component &&
                          (c->capture.empty() || c->capture == curves.id);
      if (!is_its || !rests(curves, rows[r].frame)) continue;
      const double sigma = data->sigma_of(rows[r]);
      missed += sigma * trial.fit.residuals[static_cast<Eigen::Index>(r)];
      variance += sigma * sigma;
      count += 1.0;
    }
    if (count == 0.0) continue;
    const double least = std::max(kLargest * std::abs(c->parameters.front().value),
                                  kCertain * std::sqrt(variance) / count);
    if (std::abs(missed) / count > least) return "readings at rest do not show it";
  }
  return "";
}

}  // namespace tenter::diagnosis
