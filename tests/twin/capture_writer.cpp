// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/capture_writer.h"

#include <utility>
#include <vector>

#include "tests/twin/noise_chain.h"

namespace tenter::twin {
namespace {

using capture::AxisState;
using capture::Channel;
using capture::Quantity;

constexpr double kWidthOfX = 0.10;      // m, that the x force acts on
constexpr double kWidthOfY = 0.12;      // m
constexpr double kEncoderSigma = 2e-6;  // of a stretch: 0.2 um on 0.1 m

Channel noisy_channel(const std::string& name, Quantity quantity, const std::string& unit,
                      std::vector<double> values, double sigma, const NoiseShares& shares,
                      bool declared, const std::vector<int>& run, Random& random) {
  Channel channel;
  channel.name = name;
  channel.quantity = quantity;
  channel.unit = unit;
  channel.source_unit = unit;
  channel.values = std::move(values);
  channel.resolution = add_noise(shares, sigma, run, random, channel.values);
  channel.sigma = declared ? sigma : 0.0;
  return channel;
}

AxisState from_channel(AxisState::Role role, const std::string& channel) {
  AxisState axis;
  axis.role = role;
  axis.source = AxisState::Source::channel;
  axis.channel = channel;
  return axis;
}

AxisState fixed_at(double value) {
  AxisState axis;
  axis.role = AxisState::Role::fixed;
  axis.fixed_value = value;
  return axis;
}

}  // namespace

capture::Capture write_down(const PlannedCapture& plan, const std::string& suite, Readings readings,
                            const NoiseLevels& noise, const std::array<double, 2>& step_N_m,
                            bool declared, Random& random) {
  capture::Capture capture;
  capture.kind = "homogeneous_strain";
  capture.title = "SYNTHETIC twin, " + plan.name;
  capture.specimen.name =
      "twin swatch " + (plan.specimen > 0 ? std::to_string(plan.specimen) : plan.name);
  capture.specimen.material = "twin cloth";
  capture.specimen.length_m = 0.1;
  capture.specimen.width_m = kWidthOfX;
  capture.specimen.width_y_m = kWidthOfY;
  capture.specimen.axis_angle_rad = plan.angle_rad;
  capture.protocol.name =
      "twin " + suite + " " + (plan.protocol.empty() ? plan.name : plan.protocol);
  capture.protocol.description = "pulls planned by the twin generator, suite " + suite;
  capture.protocol.history = capture::Protocol::History::continues;
  capture.protocol.phases = plan.phases;
  capture.provenance.synthetic = true;
  capture.provenance.source = "the twin generator of Tenter's tests; no cloth was pulled";
  capture.provenance.licence = "CC0-1.0";
  capture.provenance.instrument = "simulated";
  capture.runs = plan.runs;

  std::vector<double> strain_x, strain_y, shear;
  bool moves_x = false, moves_y = false;
  for (const PlannedFrame& frame : plan.frames) {
    if (!frame.recorded) continue;
    const bool first = capture.run.empty() || capture.run.back() != frame.run;
    capture.frame.push_back(first ? 1 : capture.frame.back() + 1);
    capture.run.push_back(frame.run);
    capture.phase.push_back(frame.phase);
    capture.branch.push_back(frame.branch);
    if (plan.has_time) capture.time_s.push_back(frame.time_s);
    strain_x.push_back(1.0 + frame.strain_x);
    strain_y.push_back(1.0 + frame.strain_y);
    shear.push_back(frame.shear);
    moves_x = moves_x || frame.strain_x != 0.0;
    moves_y = moves_y || frame.strain_y != 0.0;
  }

  const auto add = [&](const std::string& name, Quantity quantity, const std::string& unit,
                       std::vector<double> values, double sigma, const NoiseShares& shares) {
    capture.channels.push_back(noisy_channel(name, quantity, unit, std::move(values), sigma, shares,
                                             declared, capture.run, random));
  };
  const auto strain_axis = [&](bool is_free, bool moves, const std::string& name,
                               std::vector<double> planned, std::vector<double> observed) {
    if (is_free) {
      add(name, Quantity::stretch, "1", std::move(observed), noise.observed_stretch, NoiseShares{});
      return from_channel(AxisState::Role::observed, name);
    }
    if (!moves) return fixed_at(1.0);
    add(name, Quantity::stretch, "1", std::move(planned), kEncoderSigma, kEncoder);
    return from_channel(AxisState::Role::prescribed, name);
  };
  capture.kinematics.x =
      strain_axis(plan.free_x, moves_x, "stretch_x", std::move(strain_x), readings.stretch_x);
  capture.kinematics.y =
      strain_axis(plan.free_y, moves_y, "stretch_y", std::move(strain_y), readings.stretch_y);
  capture.kinematics.xy = fixed_at(0.0);
  if (plan.shears) {
    add("shear", Quantity::shear, "1", std::move(shear), kEncoderSigma, kEncoder);
    capture.kinematics.xy = from_channel(AxisState::Role::prescribed, "shear");
  }

  const bool in_newton = !plan.shears && !(moves_x && moves_y);
  const auto load_cell = [&](const std::string& component, std::vector<double> stress, double width,
                             double step) {
    if (stress.empty()) return;
    const std::string name = (in_newton ? "force_" : "stress_") + component;
    if (in_newton)
      for (double& value : stress) value *= width;
    add(name, in_newton ? Quantity::force : Quantity::membrane_stress, in_newton ? "N" : "N/m",
        std::move(stress), noise.stress_N_m * (in_newton ? width : 1.0), NoiseShares{});
    show_in_steps(step * (in_newton ? width : 1.0), capture.channels.back().values);
    capture.stresses.push_back({component, name});
  };
  load_cell("x", std::move(readings.stress_x), kWidthOfX, step_N_m[0]);
  load_cell("y", std::move(readings.stress_y), kWidthOfY, step_N_m[1]);
  if (plan.shears) {
    add("stress_xy", Quantity::membrane_stress, "N/m", std::move(readings.stress_shear),
        noise.shear_stress_N_m, NoiseShares{});
    capture.stresses.push_back({"xy", "stress_xy"});
  }
  return capture;
}

}  // namespace tenter::twin
