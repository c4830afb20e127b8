// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/capture/file/capture_file.h"
#include "common/capture/file/layout.h"
#include "common/capture/file/layout_source.h"
#include "common/capture/sheet/sheet_file.h"
#include "common/capture/validate.h"
#include "common/capture/vocabulary.h"
#include "common/h5/guard.h"
#include "common/h5/reader.h"

namespace tenter::capture {

namespace {

using h5::H5Reader;
using namespace layout;

Channel read_channel(Source& in, const std::string& name) {
  const std::string path = kData + "/" + name;
  Channel channel;
  channel.name = name;
  channel.values = in.doubles(path);
  channel.unit = in.text_attribute(path, "units");
  channel.quantity = in.word<Quantity>(path + "@quantity", in.text_attribute(path, "quantity"));
  channel.description = in.text_attribute(path, "description");
  channel.source_unit = in.text_attribute(path, "source_units");
  channel.sigma = in.number_attribute(path, "sigma");
  channel.resolution = in.number_attribute(path, "resolution");
  channel.may_be_missing = in.integer_attribute(path, "may_be_missing") != 0;
  if (in.ok() && channel.quantity == Quantity::position) {
    channel.point = in.text_attribute(path, "point");
    const std::string coordinate = in.text_attribute(path, "coordinate");
    if (coordinate.size() == 1)
      channel.coordinate = coordinate[0];
    else
      in.complain(path + "@coordinate", "must be x, y or z");
  }
  if (in.has(path + "_errors")) {
    in.check_unit(path + "_errors", channel.unit);
    channel.sigma_per_frame = in.doubles(path + "_errors");
  }
  return channel;
}

/// Channels are the members of the data group with an `order`, in that order.
void read_channels(Source& in, Capture& capture, std::vector<std::string>* ignored) {
  const std::set<std::string> frames = {"frame", "run", "phase", "branch", "time"};
  std::map<std::int64_t, std::string> ordered;
  for (const std::string& name : in.members(kData)) {
    const std::string path = kData + "/" + name;
    if (frames.count(name) != 0 || name.ends_with("_errors")) continue;
    if (!in.has_attribute(path, "order")) {
      if (ignored) ignored->push_back(path);
      continue;
    }
    const std::int64_t order = in.integer_attribute(path, "order");
    if (!ordered.emplace(order, name).second) in.complain(path, "has the order of another channel");
  }
  for (const auto& [order, name] : ordered) {
    if (!in.ok()) return;
    capture.channels.push_back(read_channel(in, name));
  }
}

void read_frames(Source& in, Capture& capture) {
  capture.frame = in.ints(kData + "/frame");
  capture.run = in.ints(kData + "/run");
  capture.phase = in.ints(kData + "/phase");
  for (const int code : in.ints(kData + "/branch")) {
    if (code < 0 || code > static_cast<int>(Branch::other))
      return in.complain(kData + "/branch", "holds " + std::to_string(code) + ", not 0 to 3");
    capture.branch.push_back(static_cast<Branch>(code));
  }
  if (in.has(kData + "/time")) {
    in.check_unit(kData + "/time", "s");
    capture.time_s = in.doubles(kData + "/time");
  }
}

void read_specimen(Source& in, Specimen& specimen) {
  specimen.name = in.text(kSample + "/name");
  specimen.material = in.text(kSample + "/material");
  specimen.length_m = in.optional_number(kSample + "/length", "m");
  specimen.width_m = in.optional_number(kSample + "/width", "m");
  specimen.width_y_m = in.optional_number(kSample + "/width_y", "m");
  specimen.thickness_m = in.optional_number(kSample + "/thickness", "m");
  specimen.cross_section_m2 = in.optional_number(kSample + "/cross_section", "m^2");
  specimen.mass_kg = in.optional_number(kSample + "/mass", "kg");
  specimen.area_density_kg_m2 = in.optional_number(kSample + "/area_density", "kg/m^2");
  specimen.axis_angle_rad = in.number(kSample + "/axis_angle");
  in.check_unit(kSample + "/axis_angle", "rad");
}

void read_protocol(Source& in, Capture& capture) {
  Protocol& protocol = capture.protocol;
  protocol.name = in.text(kProtocol + "/name");
  protocol.description = in.text(kProtocol + "/description");
  protocol.history =
      in.word<Protocol::History>(kProtocol + "/history", in.text(kProtocol + "/history"));
  protocol.nominal_rate_per_s = in.optional_number(kProtocol + "/nominal_rate", "1/s");
  const std::vector<std::string> names = in.texts(kProtocol + "/phase_name");
  const std::vector<std::string> kinds = in.texts(kProtocol + "/phase_kind");
  const std::vector<double> rates = in.doubles(kProtocol + "/phase_nominal_rate");
  if (kinds.size() != names.size() || rates.size() != names.size())
    return in.complain(kProtocol, "has phase lists of different lengths");
  for (std::size_t i = 0; i < names.size(); ++i) {
    Phase phase{names[i], kinds[i], std::nullopt};
    if (!std::isnan(rates[i])) phase.nominal_rate_per_s = rates[i];
    protocol.phases.push_back(std::move(phase));
  }
  const std::vector<int> numbers = in.ints(kRuns + "/number");
  const std::vector<std::string> groups = in.texts(kRuns + "/group");
  if (numbers.size() != groups.size()) return in.complain(kRuns, "has lists of different lengths");
  for (std::size_t i = 0; i < numbers.size(); ++i)
    capture.runs.push_back(Run{numbers[i], groups[i]});
}

AxisState read_axis(Source& in, const std::string& component) {
  const std::string group = kKinematics + "/" + component;
  AxisState axis;
  axis.role = in.word<AxisState::Role>(group + "/role", in.text(group + "/role"));
  axis.source = in.word<AxisState::Source>(group + "/source", in.text(group + "/source"));
  axis.channel = in.text(group + "/channel");
  axis.point_a = in.text(group + "/point_a");
  axis.point_b = in.text(group + "/point_b");
  axis.reference =
      in.word<AxisState::Reference>(group + "/reference", in.text(group + "/reference"));
  axis.reference_length_m = in.number(group + "/reference_length");
  axis.fixed_value = in.number(group + "/fixed_value");
  return axis;
}

void read_mechanics(Source& in, Capture& capture) {
  capture.kinematics.x = read_axis(in, "x");
  capture.kinematics.y = read_axis(in, "y");
  capture.kinematics.xy = read_axis(in, "xy");
  const std::vector<std::string> components = in.texts(kStresses + "/component");
  const std::vector<std::string> channels = in.texts(kStresses + "/channel");
  if (components.size() != channels.size())
    return in.complain(kStresses, "has lists of different lengths");
  for (std::size_t i = 0; i < components.size(); ++i)
    capture.stresses.push_back({components[i], channels[i]});
}

void read_provenance(Source& in, Provenance& provenance) {
  provenance.synthetic = in.integer(kProvenance + "/synthetic") != 0;
  provenance.source = in.text(kProvenance + "/source");
  provenance.licence = in.text(kProvenance + "/licence");
  provenance.authors = in.text(kProvenance + "/authors");
  provenance.instrument = in.text(kProvenance + "/instrument");
  provenance.notes = in.text(kProvenance + "/notes");
  provenance.imported_from = in.text(kProvenance + "/imported_from");
  provenance.imported_sha256 = in.text(kProvenance + "/imported_sha256");
}

/// Schema and version first: another kind of HDF5 file gets the sentence that says so. Is it of the
/// version that has a sheet?
bool read_identity(Source& in) {
  if (!in.has_attribute("/", "schema"))
    in.complain("/", "has no attribute \"schema\"; it is not a capture of Tenter");
  const std::string schema = in.text_attribute("/", "schema");
  if (in.ok() && schema != kSchema)
    in.complain("/", "has schema \"" + schema + "\", not \"" + kSchema + "\"");
  const std::int64_t version = in.integer_attribute("/", "version");
  if (in.ok() && version != kVersion && version != kSheetVersion)
    in.complain("/", "has version " + std::to_string(version) +
                         " of the layout; this program reads " + std::to_string(kVersion) +
                         " and " + std::to_string(kSheetVersion));
  return version == kSheetVersion;
}

}  // namespace

Expected<Capture> read_capture(const std::string& path, std::vector<std::string>* ignored) {
  const Expected<H5Reader> file = H5Reader::open(path);
  if (!file) return tl::unexpected(file.error());
  Source in(*file);
  Capture capture;
  std::vector<std::string> unknown;
  const bool has_sheet = read_identity(in);
  if (in.ok()) {
    capture.title = in.text(kEntry + "/title");
    capture.kind = in.text(kEntry + "/kind");
  }
  if (in.ok()) read_frames(in, capture);
  if (in.ok()) read_channels(in, capture, &unknown);
  if (in.ok()) read_specimen(in, capture.specimen);
  if (in.ok()) read_protocol(in, capture);
  if (in.ok()) read_mechanics(in, capture);
  if (in.ok()) read_provenance(in, capture.provenance);
  std::set<std::string> known = {"title", "kind",       "data",     "sample",    "protocol",
                                 "runs",  "kinematics", "stresses", "provenance"};
  if (has_sheet) {
    if (in.ok()) capture.sheet = read_sheet(in, capture.frame_count(), &unknown);
    known.insert({"meshes", "clips", "cords", "supports", "slack", "gravity"});
  }
  list_ignored(in, "/", {"entry"}, &unknown);
  list_ignored(in, kEntry, known, &unknown);
  if (!in.ok()) return tl::unexpected(in.error());
  if (auto ok = validate(capture); !ok)
    return fail(ok.error().kind, path + ": " + ok.error().message + ".");
  if (ignored) *ignored = std::move(unknown);
  return capture;
}

Expected<Capture> read_capture_guarded(const std::string& path, std::vector<std::string>* ignored) {
  const Expected<void> safe = h5::run_guarded(path, [&]() -> Expected<void> {
    const Expected<Capture> capture = read_capture(path);
    if (!capture) return tl::unexpected(capture.error());
    return {};
  });
  if (!safe) return tl::unexpected(safe.error());
  return read_capture(path, ignored);
}

}  // namespace tenter::capture
