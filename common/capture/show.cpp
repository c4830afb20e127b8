// SPDX-License-Identifier: Apache-2.0
#include "common/capture/show.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "common/capture/sheet/sheet_show.h"
#include "common/capture/show_words.h"
#include "common/capture/strips/strip_profiles.h"
#include "common/capture/vocabulary.h"

namespace tenter::capture {

namespace {

using nlohmann::ordered_json;

struct Extent {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
  std::size_t missing = 0;
};

Extent extent_of(const std::vector<double>& values) {
  Extent extent;
  for (const double value : values) {
    if (std::isnan(value)) {
      ++extent.missing;
      continue;
    }
    extent.low = std::fmin(extent.low, value);
    extent.high = std::fmax(extent.high, value);
  }
  return extent;
}

/// Pieces of one branch within one run, counted by word.
std::map<std::string, int> branch_pieces(const Capture& capture) {
  std::map<std::string, int> pieces;
  for (std::size_t i = 0; i < capture.frame_count(); ++i)
    if (i == 0 || capture.run[i] != capture.run[i - 1] ||
        capture.branch[i] != capture.branch[i - 1])
      ++pieces[to_word(capture.branch[i])];
  return pieces;
}

std::string time_in_words(const Capture& capture) {
  if (!capture.time_s.empty()) {
    const Extent extent = extent_of(capture.time_s);
    return number(extent.low) + " to " + number(extent.high) + " s";
  }
  if (capture.protocol.nominal_rate_per_s)
    return "not recorded; nominal strain rate " + number(*capture.protocol.nominal_rate_per_s) +
           " /s";
  return "not recorded, no nominal rate: rate effects can at most be AMBIGUOUS";
}

std::string specimen_in_words(const Specimen& specimen) {
  std::string text = specimen.name + " (" + specimen.material + ")";
  const auto size = [&text](const char* name, const std::optional<double>& value, double scale,
                            const char* unit) {
    if (value) text += std::string(", ") + name + " " + number(*value * scale) + " " + unit;
  };
  size("length", specimen.length_m, 1e3, "mm");
  size("width", specimen.width_m, 1e3, "mm");
  size("width across y", specimen.width_y_m, 1e3, "mm");
  size("thickness", specimen.thickness_m, 1e3, "mm");
  size("cross-section", specimen.cross_section_m2, 1e6, "mm2");
  size("mass", specimen.mass_kg, 1e3, "g");
  size("area density", specimen.area_density_kg_m2, 1e3, "g/m2");
  return text + ", x axis at " + number(specimen.axis_angle_rad * 180.0 / M_PI) +
         " degrees from the weft";
}

std::string channel_line(const Channel& channel, std::size_t name_width) {
  const Extent extent = extent_of(channel.values);
  std::string line = "  " + padded(channel.name, name_width) + "  " +
                     padded(to_word(channel.quantity), 15) + "  " + padded(channel.unit, 3) + "  " +
                     padded(number(extent.low) + " .. " + number(extent.high), 26);
  if (!channel.sigma_per_frame.empty())
    line += "  sigma per frame";
  else if (channel.sigma > 0.0)
    line += "  sigma " + number(channel.sigma);
  if (channel.resolution > 0.0) line += "  resolution " + number(channel.resolution);
  if (extent.missing > 0) line += "  missing " + std::to_string(extent.missing);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

ordered_json optional_json(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json channel_json(const Channel& channel) {
  const Extent extent = extent_of(channel.values);
  ordered_json out = {{"name", channel.name},
                      {"quantity", to_word(channel.quantity)},
                      {"unit", channel.unit},
                      {"source_unit", channel.source_unit},
                      {"description", channel.description},
                      {"lowest", extent.low},
                      {"highest", extent.high},
                      {"missing", extent.missing},
                      {"sigma", channel.sigma},
                      {"sigma_per_frame", !channel.sigma_per_frame.empty()},
                      {"resolution", channel.resolution}};
  if (channel.quantity == Quantity::position) {
    out["point"] = channel.point;
    out["coordinate"] = std::string(1, channel.coordinate);
  }
  return out;
}

ordered_json runs_json(const Capture& capture) {
  ordered_json out = ordered_json::array();
  for (std::size_t index = 0; index < capture.runs.size(); ++index)
    out.push_back(
        {{"number", capture.runs[index].number},
         {"group", capture.runs[index].group},
         {"frames", std::count(capture.run.begin(), capture.run.end(), static_cast<int>(index))}});
  return out;
}

}  // namespace

std::string axis_in_words(const AxisState& axis) {
  const std::string role = to_word(axis.role);
  if (axis.role == AxisState::Role::free) return "free (not measured)";
  if (axis.role == AxisState::Role::fixed) return "fixed at " + number(axis.fixed_value);
  std::string what = axis.source == AxisState::Source::channel
                         ? "channel " + axis.channel
                         : "distance of " + axis.point_a + " and " + axis.point_b;
  switch (axis.reference) {
    case AxisState::Reference::given:
      if (axis.reference_length_m > 0.0)
        what += " over " + number(axis.reference_length_m * 1e3) + " mm";
      break;
    case AxisState::Reference::first_frame_of_capture:
      what += " over that of the first frame of the capture";
      break;
    case AxisState::Reference::first_frame_of_run:
      what += " over that of the first frame of the run";
      break;
  }
  return role + ": " + what;
}

std::string show_text(const Capture& capture) {
  std::string out = capture.title + "\n";
  const auto line = [&out](const std::string& name, const std::string& text) {
    if (!text.empty()) out += padded(name, 12) + text + "\n";
  };
  line("kind", capture.kind + (capture.provenance.synthetic
                                   ? "  [SYNTHETIC: made by a generator, not measured]"
                                   : ""));
  line("specimen", specimen_in_words(capture.specimen));
  line("protocol", capture.protocol.name + " (" +
                       (capture.protocol.history == Protocol::History::continues
                            ? "each run goes on where the one before ended"
                            : "each run starts from a specimen never pulled") +
                       ")");
  line("", capture.protocol.description);
  for (const Phase& phase : capture.protocol.phases)
    line("phase",
         phase.name + " (" + phase.kind +
             (phase.nominal_rate_per_s ? ", " + number(*phase.nominal_rate_per_s) + " /s" : "") +
             ")");
  std::string branches;
  for (const auto& [word, count] : branch_pieces(capture))
    branches += ", " + std::to_string(count) + " " + word;
  line("frames", std::to_string(capture.frame_count()) + " in " +
                     std::to_string(capture.runs.size()) +
                     " run(s); branches: " + branches.substr(2));
  std::map<std::string, int> groups;
  for (const Run& run : capture.runs)
    if (!run.group.empty()) ++groups[run.group];
  for (const auto& [group, count] : groups)
    if (count > 1) line("repeats", std::to_string(count) + " runs of group " + group);
  if (capture.kind != kStripsKind) line("time", time_in_words(capture));
  if (!capture.sheet && capture.kind != kStripsKind) {
    line("stretch x", axis_in_words(capture.kinematics.x));
    line("stretch y", axis_in_words(capture.kinematics.y));
    line("shear xy", axis_in_words(capture.kinematics.xy));
  }
  for (const StressAssignment& stress : capture.stresses)
    line("stress " + stress.component, "channel " + stress.channel);
  const Provenance& p = capture.provenance;
  line("source", p.source);
  line("authors", p.authors);
  line("licence", p.licence.empty() ? "not stated" : p.licence);
  line("instrument", p.instrument);
  line("notes", p.notes);
  if (!p.imported_from.empty())
    line("imported", p.imported_from + ", SHA-256 " + p.imported_sha256);
  if (capture.sheet) return out + sheet_text(*capture.sheet);
  std::size_t width = 0;
  for (const Channel& channel : capture.channels) width = std::max(width, channel.name.size());
  out += "channels\n";
  for (const Channel& channel : capture.channels) out += channel_line(channel, width);
  return out;
}

ordered_json show_json(const Capture& capture) {
  const Specimen& s = capture.specimen;
  const Provenance& p = capture.provenance;
  ordered_json out;
  out["kind"] = capture.kind;
  out["title"] = capture.title;
  out["synthetic"] = p.synthetic;
  out["specimen"] = {{"name", s.name},
                     {"material", s.material},
                     {"length_m", optional_json(s.length_m)},
                     {"width_m", optional_json(s.width_m)},
                     {"width_y_m", optional_json(s.width_y_m)},
                     {"thickness_m", optional_json(s.thickness_m)},
                     {"cross_section_m2", optional_json(s.cross_section_m2)},
                     {"mass_kg", optional_json(s.mass_kg)},
                     {"area_density_kg_m2", optional_json(s.area_density_kg_m2)},
                     {"axis_angle_rad", s.axis_angle_rad}};
  ordered_json phases = ordered_json::array();
  for (const Phase& phase : capture.protocol.phases)
    phases.push_back({{"name", phase.name},
                      {"kind", phase.kind},
                      {"nominal_rate_per_s", optional_json(phase.nominal_rate_per_s)}});
  out["protocol"] = {{"name", capture.protocol.name},
                     {"description", capture.protocol.description},
                     {"history", to_word(capture.protocol.history)},
                     {"nominal_rate_per_s", optional_json(capture.protocol.nominal_rate_per_s)},
                     {"phases", phases}};
  out["frames"] = capture.frame_count();
  out["runs"] = runs_json(capture);
  out["branches"] = branch_pieces(capture);
  const Extent time = extent_of(capture.time_s);
  out["time_s"] =
      capture.time_s.empty() ? ordered_json(nullptr) : ordered_json::array({time.low, time.high});
  if (capture.sheet) out["sheet"] = sheet_json(*capture.sheet);
  out["kinematics"] = {{"x", axis_in_words(capture.kinematics.x)},
                       {"y", axis_in_words(capture.kinematics.y)},
                       {"xy", axis_in_words(capture.kinematics.xy)}};
  out["stresses"] = ordered_json::object();
  for (const StressAssignment& stress : capture.stresses)
    out["stresses"][stress.component] = stress.channel;
  out["channels"] = ordered_json::array();
  for (const Channel& channel : capture.channels) out["channels"].push_back(channel_json(channel));
  out["provenance"] = {{"source", p.source},
                       {"licence", p.licence},
                       {"authors", p.authors},
                       {"instrument", p.instrument},
                       {"notes", p.notes},
                       {"imported_from", p.imported_from},
                       {"imported_sha256", p.imported_sha256}};
  return out;
}

}  // namespace tenter::capture
