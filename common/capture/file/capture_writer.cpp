// SPDX-License-Identifier: Apache-2.0

#include "common/base/not_a_number.h"
#include "common/capture/file/capture_file.h"
#include "common/capture/file/layout.h"
#include "common/capture/sheet/sheet_file.h"
#include "common/capture/validate.h"
#include "common/capture/vocabulary.h"
#include "common/h5/writer.h"

namespace tenter::capture {

namespace {

using h5::H5Writer;
using namespace layout;

/// The axis that a viewer draws the signal over: what drives the test, else time, else the frame
/// number.
std::string default_axis(const Capture& capture) {
  for (const AxisState* axis :
       {&capture.kinematics.x, &capture.kinematics.xy, &capture.kinematics.y})
    if (axis->role == AxisState::Role::prescribed && axis->source == AxisState::Source::channel)
      return axis->channel;
  return capture.time_s.empty() ? "frame" : "time";
}

std::string default_signal(const Capture& capture) {
  if (!capture.stresses.empty()) return capture.stresses.front().channel;
  return capture.channels.front().name;
}

void write_channel(H5Writer& file, const Channel& channel, std::size_t order) {
  const std::string path = kData + "/" + channel.name;
  file.array(path, channel.values, channel.unit);
  file.attribute(path, "order", static_cast<std::int64_t>(order));
  file.attribute(path, "quantity", to_word(channel.quantity));
  file.attribute(path, "long_name",
                 channel.description.empty() ? channel.name : channel.description);
  file.attribute(path, "description", channel.description);
  file.attribute(path, "source_units", channel.source_unit);
  file.attribute(path, "sigma", channel.sigma);
  file.attribute(path, "resolution", channel.resolution);
  file.attribute(path, "may_be_missing", std::int64_t{channel.may_be_missing});
  if (channel.quantity == Quantity::position) {
    file.attribute(path, "point", channel.point);
    file.attribute(path, "coordinate", std::string(1, channel.coordinate));
  }
  if (!channel.sigma_per_frame.empty())
    file.array(path + "_errors", channel.sigma_per_frame, channel.unit);
}

void write_data(H5Writer& file, const Capture& capture) {
  file.group(kData, "NXdata");
  if (!capture.channels.empty()) {
    file.attribute(kData, "signal", default_signal(capture));
    file.attribute(kData, "axes", std::vector<std::string>{default_axis(capture)});
  }
  file.array(kData + "/frame", capture.frame);
  file.array(kData + "/run", capture.run);
  file.array(kData + "/phase", capture.phase);
  std::vector<int> branches;
  branches.reserve(capture.branch.size());
  for (const Branch branch : capture.branch) branches.push_back(static_cast<int>(branch));
  file.array(kData + "/branch", branches);
  file.attribute(kData + "/branch", "labels",
                 std::vector<std::string>{"load", "unload", "hold", "other"});
  if (!capture.time_s.empty()) file.array(kData + "/time", capture.time_s, "s");
  for (std::size_t i = 0; i < capture.channels.size(); ++i)
    write_channel(file, capture.channels[i], i);
}

void write_specimen(H5Writer& file, const Specimen& specimen) {
  file.group(kSample, "NXsample");
  file.text(kSample + "/name", specimen.name);
  file.text(kSample + "/material", specimen.material);
  const auto size = [&](const char* name, const std::optional<double>& value, const char* unit) {
    if (value) file.number(kSample + "/" + name, *value, unit);
  };
  size("length", specimen.length_m, "m");
  size("width", specimen.width_m, "m");
  size("width_y", specimen.width_y_m, "m");
  size("thickness", specimen.thickness_m, "m");
  size("cross_section", specimen.cross_section_m2, "m^2");
  size("mass", specimen.mass_kg, "kg");
  size("area_density", specimen.area_density_kg_m2, "kg/m^2");
  file.number(kSample + "/axis_angle", specimen.axis_angle_rad, "rad");
}

void write_protocol(H5Writer& file, const Capture& capture) {
  const Protocol& protocol = capture.protocol;
  file.group(kProtocol, "NXcollection");
  file.text(kProtocol + "/name", protocol.name);
  file.text(kProtocol + "/description", protocol.description);
  file.text(kProtocol + "/history", to_word(protocol.history));
  if (protocol.nominal_rate_per_s)
    file.number(kProtocol + "/nominal_rate", *protocol.nominal_rate_per_s, "1/s");
  std::vector<std::string> names;
  std::vector<std::string> kinds;
  std::vector<double> rates;
  for (const Phase& phase : protocol.phases) {
    names.push_back(phase.name);
    kinds.push_back(phase.kind);
    rates.push_back(phase.nominal_rate_per_s.value_or(kNaN));
  }
  file.array(kProtocol + "/phase_name", names);
  file.array(kProtocol + "/phase_kind", kinds);
  file.array(kProtocol + "/phase_nominal_rate", rates, "1/s");

  file.group(kRuns, "NXcollection");
  std::vector<int> numbers;
  std::vector<std::string> groups;
  for (const Run& run : capture.runs) {
    numbers.push_back(run.number);
    groups.push_back(run.group);
  }
  file.array(kRuns + "/number", numbers);
  file.array(kRuns + "/group", groups);
}

void write_axis(H5Writer& file, const std::string& component, const AxisState& axis) {
  const std::string group = kKinematics + "/" + component;
  file.group(group, "NXcollection");
  file.text(group + "/role", to_word(axis.role));
  file.text(group + "/source", to_word(axis.source));
  file.text(group + "/channel", axis.channel);
  file.text(group + "/point_a", axis.point_a);
  file.text(group + "/point_b", axis.point_b);
  file.text(group + "/reference", to_word(axis.reference));
  file.number(group + "/reference_length", axis.reference_length_m, "m");
  file.number(group + "/fixed_value", axis.fixed_value, "1");
}

void write_mechanics(H5Writer& file, const Capture& capture) {
  file.group(kKinematics, "NXcollection");
  write_axis(file, "x", capture.kinematics.x);
  write_axis(file, "y", capture.kinematics.y);
  write_axis(file, "xy", capture.kinematics.xy);
  file.group(kStresses, "NXcollection");
  std::vector<std::string> components;
  std::vector<std::string> channels;
  for (const StressAssignment& stress : capture.stresses) {
    components.push_back(stress.component);
    channels.push_back(stress.channel);
  }
  file.array(kStresses + "/component", components);
  file.array(kStresses + "/channel", channels);
}

void write_provenance(H5Writer& file, const Provenance& provenance) {
  file.group(kProvenance, "NXcollection");
  file.integer(kProvenance + "/synthetic", provenance.synthetic ? 1 : 0);
  file.text(kProvenance + "/source", provenance.source);
  file.text(kProvenance + "/licence", provenance.licence);
  file.text(kProvenance + "/authors", provenance.authors);
  file.text(kProvenance + "/instrument", provenance.instrument);
  file.text(kProvenance + "/notes", provenance.notes);
  file.text(kProvenance + "/imported_from", provenance.imported_from);
  file.text(kProvenance + "/imported_sha256", provenance.imported_sha256);
}

}  // namespace

Expected<void> write_capture(const Capture& capture, const std::string& path) {
  if (auto ok = validate(capture); !ok)
    return fail(ok.error().kind, path + ": " + ok.error().message + ".");
  H5Writer file(path);
  file.group("/", "NXroot");
  file.attribute("/", "default", std::string("entry"));
  file.attribute("/", "schema", std::string(kSchema));
  file.attribute("/", "version", capture.sheet ? kSheetVersion : kVersion);
  file.group(kEntry, "NXentry");
  file.attribute(kEntry, "default", capture.sheet ? default_group(*capture.sheet) : "data");
  file.text(kEntry + "/title", capture.title);
  file.text(kEntry + "/kind", capture.kind);
  write_data(file, capture);
  write_specimen(file, capture.specimen);
  write_protocol(file, capture);
  write_mechanics(file, capture);
  write_provenance(file, capture.provenance);
  if (capture.sheet) write_sheet(file, *capture.sheet, capture.frame_count());
  return std::move(file).save();
}

}  // namespace tenter::capture
