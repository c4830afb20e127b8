// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/end_to_end/support/captures.h"

#include <gtest/gtest.h>

#include <random>

#include "common/capture/file/capture_file.h"

namespace tenter::test {

void write_noise_capture(const std::filesystem::path& path, std::size_t frames,
                         std::size_t channels, std::uint32_t seed) {
  using capture::AxisState;
  capture::Capture c;
  c.kind = "homogeneous_strain";
  c.title = "noise " + std::to_string(seed);
  c.specimen = {.name = "s1",
                .material = "m",
                .length_m = 0.1,
                .width_m = 0.05,
                .width_y_m = {},
                .thickness_m = {},
                .cross_section_m2 = {},
                .mass_kg = {},
                .area_density_kg_m2 = {}};
  c.protocol.name = "pull";
  c.protocol.phases = {{"pull", "ramp", 0.01}};
  c.provenance.synthetic = true;
  c.provenance.source = "made for a test";
  c.kinematics.x = {.role = AxisState::Role::prescribed,
                    .source = AxisState::Source::channel,
                    .channel = "stretch_x",
                    .point_a = {},
                    .point_b = {}};
  c.kinematics.y.role = AxisState::Role::free;
  c.kinematics.xy.role = AxisState::Role::fixed;
  c.kinematics.xy.fixed_value = 0.0;
  c.stresses = {{"x", "force"}};
  c.runs = {{1, ""}};
  c.frame.resize(frames);
  c.run.assign(frames, 0);
  c.phase.assign(frames, 0);
  c.branch.assign(frames, capture::Branch::load);
  c.time_s.resize(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    c.frame[i] = static_cast<int>(i);
    c.time_s[i] = 0.01 * static_cast<double>(i);
  }
  std::mt19937_64 random(seed);
  const auto add = [&](const std::string& name, capture::Quantity quantity, const char* unit,
                       double base, double spread) {
    capture::Channel channel;
    channel.name = name;
    channel.quantity = quantity;
    channel.unit = unit;
    channel.source_unit = unit;
    channel.sigma = 1e-3;
    channel.values.resize(frames);
    for (double& value : channel.values)
      value = base + spread * static_cast<double>(random() >> 11) * 0x1p-53;
    c.channels.push_back(std::move(channel));
  };
  add("stretch_x", capture::Quantity::stretch, "1", 1.0, 0.5);
  add("force", capture::Quantity::force, "N", 1.0, 10.0);
  for (std::size_t i = 0; i < channels; ++i)
    add("other_" + std::to_string(i), capture::Quantity::other, "1", 0.0, 1.0);
  const auto written = capture::write_capture(c, path.string());
  ASSERT_TRUE(written) << written.error().message;
}

}  // namespace tenter::test
