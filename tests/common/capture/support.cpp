// SPDX-License-Identifier: Apache-2.0
#include "tests/common/capture/support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"

namespace tenter::capture::test {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  std::string pattern = (fs::temp_directory_path() / "tenter-capture-XXXXXX").string();
  if (!::mkdtemp(pattern.data())) std::abort();
  folder_ = pattern;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::size_t TempFolder::file_count() const {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
}

void put_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string get_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

namespace {

Channel channel(const std::string& name, Quantity quantity, const std::string& unit,
                std::vector<double> values) {
  Channel out;
  out.name = name;
  out.quantity = quantity;
  out.unit = unit;
  out.source_unit = unit;
  out.values = std::move(values);
  return out;
}

}  // namespace

Capture small_capture() {
  Capture c;
  c.kind = "tracked_points";
  c.title =
      "A small capture, with \"quotes\", a comma and gr\xC3\xB6\xC3\x9F"
      "e";
  c.specimen.name = "S1";
  c.specimen.material = "cloth";
  c.specimen.width_m = 0.05;
  c.specimen.width_y_m = 0.07;
  c.specimen.mass_kg = 0.1 + 0.2;
  c.specimen.axis_angle_rad = 0.785398;
  c.protocol.name = "two pulls";
  c.protocol.history = Protocol::History::virgin_each_run;
  c.protocol.nominal_rate_per_s = 0.01;
  c.protocol.phases = {{"pull", "ramp", 0.02}, {"rest", "hold", std::nullopt}};
  c.provenance.synthetic = true;
  c.provenance.source = "a test";
  c.provenance.notes = "line one\nline two";
  c.runs = {{3, "g"}, {7, "g"}};
  c.frame = {1, 5, 9, 1, 2, 3};
  c.run = {0, 0, 0, 1, 1, 1};
  c.phase = {0, 0, 1, 0, 0, 1};
  c.branch = {Branch::load,   Branch::load,  Branch::hold,
              Branch::unload, Branch::other, Branch::hold};
  c.time_s = {0.0, 0.1, 0.3, 0.0, 1.0 / 3.0, 1.0};
  c.channels.push_back(channel("force", Quantity::force, "N", {0, 1.5, 2.5, 0.1, 1.7, 1e-300}));
  c.channels.back().sigma = 0.02;
  c.channels.back().resolution = 0.01;
  c.channels.back().source_unit = "lbf";
  c.channels.back().description = "load cell, under the clamp";
  c.channels.push_back(channel("stretch_x", Quantity::stretch, "1", {1, 1.1, 1.2, 1, 1.15, 1.2}));
  c.channels.back().sigma_per_frame = {0.001, 0.001, 0.002, 0.001, 0.001, 0.0};
  c.channels.push_back(channel("humidity", Quantity::other, "percent", {40, 41, 40, 40, 40, 40}));
  c.channels.back().values[2] = std::numeric_limits<double>::quiet_NaN();
  c.channels.back().may_be_missing = true;
  for (const std::string point : {"left", "right"})
    for (const char coordinate : {'x', 'y'}) {
      c.channels.push_back(channel(point + "_" + coordinate, Quantity::position, "m",
                                   {0.01, 0.02, 0.03, 0.01, 0.02, 0.035}));
      c.channels.back().point = point;
      c.channels.back().coordinate = coordinate;
    }
  c.kinematics.x.role = AxisState::Role::prescribed;
  c.kinematics.x.source = AxisState::Source::channel;
  c.kinematics.x.channel = "stretch_x";
  c.kinematics.y.role = AxisState::Role::observed;
  c.kinematics.y.source = AxisState::Source::points;
  c.kinematics.y.point_a = "left";
  c.kinematics.y.point_b = "right";
  c.kinematics.y.reference = AxisState::Reference::first_frame_of_run;
  c.stresses = {{"x", "force"}};
  return c;
}

std::string bytes_of(const Capture& capture) {
  const TempFolder folder;
  const Expected<void> done = write_capture(capture, folder.path("c.h5"));
  EXPECT_TRUE(done) << message_of(done);
  return get_file(folder.path("c.h5"));
}

std::string uniaxial_description(const std::string& merge_patch) {
  nlohmann::json base = nlohmann::json::parse(R"({
    "kind": "homogeneous_strain", "title": "Strip",
    "columns": {
      "time_s": {"is": "time", "unit": "s"},
      "displacement_mm": {"channel": "displacement", "quantity": "displacement", "unit": "mm"},
      "force_N": {"channel": "force", "quantity": "force", "unit": "N"}
    },
    "specimen": {"name": "A", "material": "poplin", "width": {"value": 50, "unit": "mm"}},
    "protocol": {"name": "pull", "history": "continues"},
    "provenance": {"source": "a test"},
    "kinematics": {
      "x": {"role": "prescribed", "channel": "displacement", "reference_length": {"value": 80, "unit": "mm"}},
      "y": {"role": "free"}
    },
    "stresses": {"x": "force"}
  })");
  base.merge_patch(nlohmann::json::parse(merge_patch));
  return base.dump();
}

Expected<Capture> import_text(const std::string& csv, const std::string& description) {
  const TempFolder folder;
  put_file(folder.path("pull.csv"), csv);
  put_file(folder.path("pull.json"), description);
  return import_csv(folder.path("pull.csv"), folder.path("pull.json"));
}

}  // namespace tenter::capture::test
