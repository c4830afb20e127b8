// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_export.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/atomic_write.h"
#include "common/capture/csv/csv_export_parts.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/vocabulary.h"

namespace tenter::capture {

namespace {

using nlohmann::ordered_json;

bool has_groups(const Capture& capture) {
  return std::any_of(capture.runs.begin(), capture.runs.end(),
                     [](const Run& run) { return !run.group.empty(); });
}

ordered_json measure(double value, const char* unit) {
  return {{"value", value}, {"unit", unit}};
}

ordered_json describe_channel(const Channel& channel) {
  ordered_json column;
  column["channel"] = channel.name;
  column["quantity"] = to_word(channel.quantity);
  column["unit"] = channel.unit;
  column["source_unit"] = channel.source_unit;
  if (!channel.description.empty()) column["description"] = channel.description;
  if (channel.quantity == Quantity::position) {
    column["point"] = channel.point;
    column["coordinate"] = std::string(1, channel.coordinate);
  }
  if (channel.sigma > 0.0) column["sigma"] = channel.sigma;
  if (!channel.sigma_per_frame.empty()) column["sigma_column"] = channel.name + "_errors";
  if (channel.resolution > 0.0) column["resolution"] = channel.resolution;
  if (channel.may_be_missing) column["missing"] = "allowed";
  return column;
}

}  // namespace

ordered_json describe_columns(const Capture& capture) {
  ordered_json columns;
  columns["run"] = {{"is", "run"}};
  if (has_groups(capture)) columns["group"] = {{"is", "group"}};
  columns["frame"] = {{"is", "frame"}};
  if (capture.protocol.phases.size() > 1) columns["phase"] = {{"is", "phase"}};
  columns["branch"] = {{"is", "branch"}};
  if (!capture.time_s.empty()) columns["time"] = {{"is", "time"}, {"unit", "s"}};
  for (const Channel& channel : capture.channels) columns[channel.name] = describe_channel(channel);
  return columns;
}

ordered_json describe_specimen(const Specimen& specimen) {
  ordered_json out = {{"name", specimen.name}, {"material", specimen.material}};
  const auto put = [&out](const char* key, const std::optional<double>& value, const char* unit) {
    if (value) out[key] = measure(*value, unit);
  };
  put("length", specimen.length_m, "m");
  put("width", specimen.width_m, "m");
  put("width_y", specimen.width_y_m, "m");
  put("thickness", specimen.thickness_m, "m");
  put("cross_section", specimen.cross_section_m2, "m2");
  put("mass", specimen.mass_kg, "kg");
  put("area_density", specimen.area_density_kg_m2, "kg/m2");
  out["axis_angle"] = measure(specimen.axis_angle_rad, "radian");
  return out;
}

ordered_json describe_protocol(const Protocol& protocol) {
  ordered_json out = {{"name", protocol.name},
                      {"description", protocol.description},
                      {"history", to_word(protocol.history)}};
  if (protocol.nominal_rate_per_s) out["nominal_rate_per_s"] = *protocol.nominal_rate_per_s;
  out["phases"] = ordered_json::array();
  for (const Phase& phase : protocol.phases) {
    ordered_json item = {{"name", phase.name}, {"kind", phase.kind}};
    if (phase.nominal_rate_per_s) item["nominal_rate_per_s"] = *phase.nominal_rate_per_s;
    out["phases"].push_back(std::move(item));
  }
  return out;
}

ordered_json describe_provenance(const Provenance& provenance) {
  return {{"synthetic", provenance.synthetic},
          {"source", provenance.source},
          {"licence", provenance.licence},
          {"authors", provenance.authors},
          {"instrument", provenance.instrument},
          {"notes", provenance.notes},
          {"imported_from", provenance.imported_from},
          {"imported_sha256", provenance.imported_sha256}};
}

namespace {

ordered_json describe_axis(const AxisState& axis) {
  ordered_json out = {{"role", to_word(axis.role)}};
  if (axis.source == AxisState::Source::channel) out["channel"] = axis.channel;
  if (axis.source == AxisState::Source::points) out["points"] = {axis.point_a, axis.point_b};
  if (axis.reference != AxisState::Reference::given) out["reference"] = to_word(axis.reference);
  if (axis.reference_length_m != 0.0)
    out["reference_length"] = measure(axis.reference_length_m, "m");
  out["value"] = axis.fixed_value;
  return out;
}

std::string description_of(const Capture& capture) {
  ordered_json root;
  root["schema"] = "tenter.describe";
  root["version"] = 1;
  root["kind"] = capture.kind;
  root["title"] = capture.title;
  root["columns"] = describe_columns(capture);
  root["specimen"] = describe_specimen(capture.specimen);
  root["protocol"] = describe_protocol(capture.protocol);
  root["provenance"] = describe_provenance(capture.provenance);
  root["kinematics"] = {{"x", describe_axis(capture.kinematics.x)},
                        {"y", describe_axis(capture.kinematics.y)},
                        {"xy", describe_axis(capture.kinematics.xy)}};
  ordered_json stresses = ordered_json::object();
  for (const StressAssignment& stress : capture.stresses)
    stresses[stress.component] = stress.channel;
  root["stresses"] = std::move(stresses);
  return root.dump(2) + "\n";
}

}  // namespace

std::string table_of(const Capture& capture) {
  const bool groups = has_groups(capture);
  const bool phases = capture.protocol.phases.size() > 1;
  std::string csv = std::string("run,") + (groups ? "group," : "") + "frame," +
                    (phases ? "phase," : "") + "branch";
  if (!capture.time_s.empty()) csv += ",time";
  for (const Channel& channel : capture.channels) {
    csv += "," + channel.name;
    if (!channel.sigma_per_frame.empty()) csv += "," + channel.name + "_errors";
  }
  csv += "\n";
  for (std::size_t i = 0; i < capture.frame_count(); ++i) {
    const Run& run = capture.runs[static_cast<std::size_t>(capture.run[i])];
    csv += std::to_string(run.number) + ",";
    if (groups) csv += csv_cell(run.group) + ",";
    csv += std::to_string(capture.frame[i]) + ",";
    if (phases)
      csv +=
          csv_cell(capture.protocol.phases[static_cast<std::size_t>(capture.phase[i])].name) + ",";
    csv += to_word(capture.branch[i]);
    if (!capture.time_s.empty()) csv += "," + csv_number(capture.time_s[i]);
    for (const Channel& channel : capture.channels) {
      csv += "," + csv_number(channel.values[i]);
      if (!channel.sigma_per_frame.empty()) csv += "," + csv_number(channel.sigma_per_frame[i]);
    }
    csv += "\n";
  }
  return csv;
}

CsvExport export_csv(const Capture& capture) {
  return {table_of(capture), description_of(capture)};
}

Expected<void> write_csv_export(const Capture& capture, const std::string& csv_path,
                                const std::string& description_path) {
  const CsvExport files = export_csv(capture);
  if (auto ok = write_atomically(csv_path, files.csv.data(), files.csv.size()); !ok) return ok;
  return write_atomically(description_path, files.description.data(), files.description.size());
}

}  // namespace tenter::capture
