// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/finite_measures.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tenter::capture {

namespace {

/// Stretch of every frame where a channel of stretches or strains gives it, or it is fixed.
std::optional<std::vector<double>> stretches(const Capture& capture, const AxisState& axis) {
  if (axis.role == AxisState::Role::fixed)
    return std::vector<double>(capture.frame.size(), axis.fixed_value);
  if (axis.source != AxisState::Source::channel) return std::nullopt;
  const Channel* channel = capture.find(axis.channel);
  if (!channel || (channel->quantity != Quantity::stretch && channel->quantity != Quantity::strain))
    return std::nullopt;
  std::vector<double> values = channel->values;
  if (channel->quantity == Quantity::strain)
    for (double& value : values) value += 1.0;
  return values;
}

bool is_free_of_stress(const AxisState& axis) {
  return axis.role == AxisState::Role::free || axis.role == AxisState::Role::observed;
}

}  // namespace

std::optional<double> engineering_strain(double green_strain) {
  const double squared_stretch = 1.0 + 2.0 * green_strain;
  if (squared_stretch <= 0.0) return std::nullopt;
  return std::sqrt(squared_stretch) - 1.0;
}

Expected<void> make_stresses_nominal(const Description& description, const std::string& json_name,
                                     Capture& capture) {
  const Kinematics& is = capture.kinematics;
  for (const ColumnDescription& column : description.columns) {
    if (column.measure != Measure::second_piola) continue;
    const auto refuse = [&](const std::string& what) {
      return bad_input(json_name + ": columns." + column.csv + ".measure \"second_piola\" " + what +
                       ".");
    };
    Channel& channel =
        *std::find_if(capture.channels.begin(), capture.channels.end(),
                      [&](const Channel& c) { return c.name == column.channel.name; });
    const auto assigned =
        std::find_if(capture.stresses.begin(), capture.stresses.end(),
                     [&](const StressAssignment& s) { return s.channel == channel.name; });
    if (assigned == capture.stresses.end()) return refuse("needs its component in stresses");
    const std::string& component = assigned->component;
    // P_x = x S_x + xy S_xy, P_y = y S_y, P_xy = x S_xy + xy S_y
    if (component == "x" && (is.xy.role != AxisState::Role::fixed || is.xy.fixed_value != 0.0))
      return refuse("along x needs a test without shear");
    if (component == "xy" && !is_free_of_stress(is.y))
      return refuse("of shear needs a y direction free of stress");
    const auto stretch = stretches(capture, component == "y" ? is.y : is.x);
    if (!stretch)
      return refuse(std::string("needs the stretch along ") + (component == "y" ? "y" : "x") +
                    " as a channel of stretches or strains, or fixed");
    for (std::size_t i = 0; i < channel.values.size(); ++i) channel.values[i] *= (*stretch)[i];
  }
  return {};
}

}  // namespace tenter::capture
