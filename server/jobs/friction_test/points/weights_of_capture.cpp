// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/points/weights_of_capture.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/curves.h"
#include "server/jobs/friction_test/axis_of_cloth.h"

namespace tenter::jobs {
namespace {

/// Of one stretch; 0 where the capture does not say.
double stretch_noise(const capture::Capture& capture, double rest_length_m) {
  const auto& channels = capture.channels;
  const auto found =
      std::find_if(channels.begin(), channels.end(), [&](const capture::Channel& channel) {
        return channel.name == capture.kinematics.x.channel;
      });
  if (found == channels.end() || !(found->sigma > 0.0)) return 0.0;
  const bool is_ratio =
      found->quantity == capture::Quantity::stretch || found->quantity == capture::Quantity::strain;
  if (is_ratio) return found->sigma;
  return rest_length_m > 0.0 ? found->sigma / rest_length_m : 0.0;
}

}  // namespace

Expected<WeightsOfCapture> weights_of(const capture::Capture& capture, const std::string& id) {
  using Role = capture::AxisState::Role;
  const std::string name = "capture \"" + capture.title + "\": ";
  if (capture.kinematics.x.role != Role::prescribed)
    return bad_input(name + "hanging weights need the length along x, as prescribed stretch");
  WeightsOfCapture result;
  const std::string axis = axis_of_cloth(capture.specimen.axis_angle_rad);
  result.measure = "green_" + axis;
  if (axis.empty())
    return bad_input(
        name +
        "specimen.axis_angle: its x axis lies along neither weft nor warp; friction is estimated "
        "for each of them on its own");
  const auto curves = estimation::make_curves(capture, id);
  if (!curves) return tl::unexpected(curves.error());
  const auto load = std::find_if(curves->channels.begin(), curves->channels.end(),
                                 [](const estimation::ObservedChannel& channel) {
                                   return channel.is_stress && channel.component == 0;
                                 });
  if (load == curves->channels.end())
    return bad_input(name + "no channel gives the weight, as stress along x");
  if (curves->dropped_frames > 0)
    return bad_input(name + std::to_string(curves->dropped_frames) +
                     " lengths are missing; what was hung on in between cannot be left out");
  estimation::WeightTable& table = result.table;
  table.rest_length_m = table.width_m = 1.0;
  for (std::size_t r = 0; r < curves->runs.size(); ++r)
    for (int i = curves->runs[r].first; i < curves->runs[r].last; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!std::isfinite(load->measured[k]))
        return bad_input(name + "frame " + std::to_string(curves->frame[k]) + ": no weight");
      table.readings.push_back({load->measured[k], curves->path.q[k][0], static_cast<int>(r)});
    }
  table.between = capture.protocol.history == capture::Protocol::History::virgin_each_run
                      ? estimation::BetweenRuns::flattened
                      : estimation::BetweenRuns::goes_on;
  result.rest_length_m = capture.kinematics.x.reference_length_m > 0.0
                             ? capture.kinematics.x.reference_length_m
                             : capture.specimen.length_m.value_or(0.0);
  table.length_noise_m = stretch_noise(capture, result.rest_length_m);
  return result;
}

}  // namespace tenter::jobs
