// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/description.h"

#include <algorithm>
#include <array>

#include "common/base/text_file.h"
#include "common/capture/csv/description_parts.h"
#include "common/capture/strict_json.h"
#include "common/capture/strips/strip_profiles.h"
#include "common/capture/vocabulary.h"

namespace tenter::capture {

namespace {

constexpr std::size_t kMaxDescriptionBytes = 16000000;

template <class Enum>
Enum word_of(JsonObject& object, const std::string& key, const std::string& text) {
  const std::optional<Enum> value = from_word<Enum>(text);
  if (!value && object.has(key))
    object.defect().note(object.path_of(key), "is \"" + text + "\", not one of " + words<Enum>());
  return value.value_or(Enum{});
}

UnitConversion unit_of_column(JsonObject& column, const std::string& si_unit) {
  if (!column.has("unit")) {
    column.defect().note(
        column.path_of("unit"),
        "is missing; every measured column names its unit (\"1\" for a plain number)");
    return {};
  }
  const Expected<UnitConversion> to_si = conversion(column.text("unit"), si_unit);
  if (to_si) return *to_si;
  column.defect().note(column.path_of("unit") + ":", to_si.error().message);
  return {};
}

/// What is said of the errors would change from frame to frame with the stretch.
Measure read_measure(JsonObject& column, const Channel& channel) {
  if (!column.has("measure")) return Measure::held;
  for (const char* key : {"sigma", "resolution", "sigma_column"})
    if (column.has(key))
      column.defect().note(column.path_of(key), "cannot be given in a measure of finite strain");
  const std::string word = column.text("measure");
  if (word == "green" && channel.quantity == Quantity::strain) return Measure::green;
  if (word == "second_piola" && is_force_like(channel.quantity)) return Measure::second_piola;
  column.defect().note(column.path_of("measure"),
                       "must be \"green\" of a strain or \"second_piola\" of a stress or force");
  return Measure::held;
}

void read_channel(JsonObject& column, ColumnDescription& out) {
  out.is_channel = true;
  Channel& channel = out.channel;
  channel.name = column.text_or("channel", out.csv);
  channel.quantity = word_of<Quantity>(column, "quantity", column.text("quantity"));
  const std::string unit = column.text_or("unit", "");
  channel.unit = channel.quantity == Quantity::other ? unit : unit_of(channel.quantity);
  out.to_si = channel.quantity == Quantity::other && !unit.empty()
                  ? UnitConversion{}
                  : unit_of_column(column, channel.unit);
  channel.source_unit = column.text_or("source_unit", unit);
  channel.description = column.text_or("description", "");
  channel.sigma = out.to_si.apply_to_difference(column.maybe_number("sigma").value_or(0.0));
  channel.resolution =
      out.to_si.apply_to_difference(column.maybe_number("resolution").value_or(0.0));
  out.sigma_column = column.text_or("sigma_column", "");
  out.measure = read_measure(column, channel);
  const std::string missing = column.text_or("missing", "error");
  if (missing != "allowed" && missing != "error")
    column.defect().note(column.path_of("missing"), "must be \"allowed\" or \"error\"");
  channel.may_be_missing = missing == "allowed";
  if (channel.quantity != Quantity::position) return;
  channel.point = column.text("point");
  const std::string coordinate = column.text("coordinate");
  if (coordinate == "x" || coordinate == "y" || coordinate == "z")
    channel.coordinate = coordinate[0];
  else
    column.defect().note(column.path_of("coordinate"), "must be \"x\", \"y\" or \"z\"");
}

void read_branch_words(JsonObject& column, ColumnDescription& out) {
  std::optional<JsonObject> values = column.maybe_object("values");
  if (!values) return;
  for (const std::string& key : values->keys()) {
    const std::string word = values->text(key);
    word_of<Branch>(*values, key, word);
    out.branch_words[key] = word;
  }
}

}  // namespace

ColumnDescription read_column(JsonObject& columns, const std::string& name) {
  ColumnDescription out;
  out.csv = name;
  if (const nlohmann::json* value = columns.raw(name); value && *value == "ignore") {
    out.is_ignored = true;
    return out;
  }
  JsonObject column = columns.object(name);
  if (!column.has("is")) {
    read_channel(column, out);
    column.finish();
    return out;
  }
  for (const std::string& use : column.texts("is")) {
    if (use == "time")
      out.is_time = true;
    else if (use == "frame")
      out.is_frame = true;
    else if (use == "run")
      out.is_run = true;
    else if (use == "group")
      out.is_group = true;
    else if (use == "phase")
      out.is_phase = true;
    else if (use == "branch")
      out.is_branch = true;
    else if (use == "ignore")
      out.is_ignored = true;
    else
      column.defect().note(
          column.path_of("is"),
          "is \"" + use + "\", not one of time, frame, run, group, phase, branch, ignore");
  }
  if (out.is_time) out.to_si = unit_of_column(column, "s");
  if (out.is_branch) read_branch_words(column, out);
  column.finish();
  return out;
}

void check_columns(const Description& out, JsonDefect& defect) {
  const std::array<std::pair<bool ColumnDescription::*, const char*>, 6> single = {
      {{&ColumnDescription::is_time, "time"},
       {&ColumnDescription::is_frame, "frame"},
       {&ColumnDescription::is_run, "run"},
       {&ColumnDescription::is_group, "group"},
       {&ColumnDescription::is_phase, "phase"},
       {&ColumnDescription::is_branch, "branch"}}};
  for (const auto& [use, word] : single)
    if (std::count_if(out.columns.begin(), out.columns.end(),
                      [use = use](const ColumnDescription& c) { return c.*use; }) > 1)
      defect.note("columns", std::string("name two columns as ") + word);
  for (const ColumnDescription& column : out.columns)
    if (!column.sigma_column.empty())
      for (const ColumnDescription& other : out.columns)
        if (other.csv == column.sigma_column && !other.is_ignored)
          defect.note("columns." + column.csv + ".sigma_column",
                      "names a column that is described as something else");
}

void check_protocol_against_columns(const Description& out, JsonDefect& defect) {
  if (out.runs_repeat && out.find(&ColumnDescription::is_group))
    defect.note("protocol.repeats", "contradicts the column that gives the group");
  if (out.head.protocol.name.empty()) defect.note("protocol.name", "is empty");
  if (out.branch && out.find(&ColumnDescription::is_branch))
    defect.note("protocol.branch", "contradicts the column that gives the branch");
}

void read_specimen(JsonObject object, Specimen& out) {
  out.name = object.text("name");
  out.material = object.text("material");
  out.length_m = object.maybe_measure("length", "m");
  out.width_m = object.maybe_measure("width", "m");
  out.width_y_m = object.maybe_measure("width_y", "m");
  out.thickness_m = object.maybe_measure("thickness", "m");
  out.cross_section_m2 = object.maybe_measure("cross_section", "m2");
  out.mass_kg = object.maybe_measure("mass", "kg");
  out.area_density_kg_m2 = object.maybe_measure("area_density", "kg/m2");
  out.axis_angle_rad = object.maybe_measure("axis_angle", "radian").value_or(0.0);
  object.finish();
}

void read_protocol(JsonObject object, Description& out) {
  Protocol& protocol = out.head.protocol;
  protocol.name = object.text("name");
  protocol.description = object.text_or("description", "");
  protocol.history = word_of<Protocol::History>(object, "history", object.text("history"));
  protocol.nominal_rate_per_s = object.maybe_number("nominal_rate_per_s");
  out.runs_repeat = object.flag_or("repeats", false);
  if (object.has("branch")) out.branch = word_of<Branch>(object, "branch", object.text("branch"));
  for (JsonObject& item : object.objects("phases")) {
    Phase phase;
    phase.name = item.text("name");
    phase.kind = item.text_or("kind", "other");
    phase.nominal_rate_per_s = item.maybe_number("nominal_rate_per_s");
    item.finish();
    protocol.phases.push_back(std::move(phase));
  }
  object.finish();
}

void read_provenance(JsonObject object, Description& description) {
  Provenance& out = description.head.provenance;
  description.origin_given = object.has("imported_from");
  out.synthetic = object.flag_or("synthetic", false);
  out.source = object.text("source");
  out.licence = object.text_or("licence", "");
  out.authors = object.text_or("authors", "");
  out.instrument = object.text_or("instrument", "");
  out.notes = object.text_or("notes", "");
  out.imported_from = object.text_or("imported_from", "");
  out.imported_sha256 = object.text_or("imported_sha256", "");
  object.finish();
}

namespace {

AxisState read_axis(JsonObject object, double fixed_otherwise) {
  AxisState axis;
  axis.fixed_value = fixed_otherwise;
  axis.role = word_of<AxisState::Role>(object, "role", object.text("role"));
  if (const std::optional<std::string> channel = object.maybe_text("channel")) {
    axis.source = AxisState::Source::channel;
    axis.channel = *channel;
  }
  if (object.has("points")) {
    const std::vector<std::string> points = object.texts("points");
    if (axis.source == AxisState::Source::channel || points.size() != 2)
      object.defect().note(object.path_of("points"), "must be two points, in place of a channel");
    axis.source = AxisState::Source::points;
    if (points.size() == 2) {
      axis.point_a = points[0];
      axis.point_b = points[1];
    }
  }
  axis.reference =
      word_of<AxisState::Reference>(object, "reference", object.text_or("reference", "given"));
  axis.reference_length_m = object.maybe_measure("reference_length", "m").value_or(0.0);
  if (const std::optional<double> value = object.maybe_number("value")) axis.fixed_value = *value;
  object.finish();
  return axis;
}

void read_kinematics(JsonObject object, Kinematics& out) {
  out.x = read_axis(object.object("x"), 1.0);
  out.y = read_axis(object.object("y"), 1.0);
  if (std::optional<JsonObject> xy = object.maybe_object("xy")) out.xy = read_axis(*xy, 0.0);
  object.finish();
}

}  // namespace

void read_file_options(JsonObject& root, Description& out) {
  const std::string separator = root.text_or("separator", ",");
  if (separator != "," && separator != ";" && separator != "\t")
    root.defect().note("separator", "must be \",\", \";\" or a tab");
  else
    out.csv.separator = separator[0];
  const std::string decimal = root.text_or("decimal", ".");
  if (decimal != "." && (decimal != "," || out.csv.separator == ','))
    root.defect().note("decimal", "must be \".\", or \",\" with another separator");
  out.decimal_comma = decimal == ",";
  const double skip = root.maybe_number("skip_lines").value_or(0.0);
  if (skip < 0.0 || skip > 10000.0 || skip != static_cast<double>(static_cast<int>(skip)))
    root.defect().note("skip_lines", "must be a whole number from 0 to 10000");
  else
    out.csv.skip_lines = static_cast<std::size_t>(skip);
  const double rows = root.maybe_number("skip_rows").value_or(0.0);
  if (rows < 0.0 || rows > 100.0 || rows != static_cast<double>(static_cast<int>(rows)))
    root.defect().note("skip_rows", "must be a whole number from 0 to 100");
  else
    out.csv.skip_rows = static_cast<std::size_t>(rows);
  const std::string others = root.text_or("other_columns", "error");
  if (others != "error" && others != "ignore")
    root.defect().note("other_columns", "must be \"error\" or \"ignore\"");
  out.ignore_other_columns = others == "ignore";
  if (std::optional<JsonObject> where = root.maybe_object("where"))
    for (const std::string& column : where->keys())
      out.where.emplace_back(column, where->texts(column));
}

namespace {

void read_root(JsonObject& root, Description& out) {
  if (const std::string schema = root.text_or("schema", "tenter.describe");
      schema != "tenter.describe")
    root.defect().note("schema", "is \"" + schema + "\", not \"tenter.describe\"");
  if (root.maybe_number("version").value_or(1.0) != 1.0) root.defect().note("version", "must be 1");
  out.head.kind = root.text("kind");
  out.head.title = root.text("title");
  read_file_options(root, out);
  JsonObject columns = root.object("columns");
  for (const std::string& name : columns.keys()) out.columns.push_back(read_column(columns, name));
  check_columns(out, root.defect());
  read_specimen(root.object("specimen"), out.head.specimen);
  read_protocol(root.object("protocol"), out);
  read_provenance(root.object("provenance"), out);
  // the profile of a strip has no strain that is the same everywhere
  if (out.head.kind != kStripsKind || root.has("kinematics"))
    read_kinematics(root.object("kinematics"), out.head.kinematics);
  if (std::optional<JsonObject> stresses = root.maybe_object("stresses"))
    for (const std::string& component : stresses->keys())
      out.head.stresses.push_back({component, stresses->text(component)});
  out.assume_unit_width = root.flag_or("assume_unit_width", false);
  out.assume_unit_thickness = root.flag_or("assume_unit_thickness", false);
  const Specimen& specimen = out.head.specimen;
  if (out.assume_unit_width && (specimen.width_m || specimen.cross_section_m2))
    root.defect().note("assume_unit_width", "contradicts the size that specimen gives");
  if (out.assume_unit_thickness && specimen.thickness_m)
    root.defect().note("assume_unit_thickness", "contradicts specimen.thickness");
  check_protocol_against_columns(out, root.defect());
  root.finish();
}

}  // namespace

const ColumnDescription* Description::find(bool ColumnDescription::*use) const {
  for (const ColumnDescription& column : columns)
    if (column.*use) return &column;
  return nullptr;
}

Expected<Description> parse_description(const std::string& text, const std::string& name) {
  const Expected<nlohmann::json> document = parse_json(text, name);
  if (!document) return tl::unexpected(document.error());
  JsonDefect defect;
  JsonObject root(*document, "", defect);
  Description description;
  read_root(root, description);
  if (defect) return bad_input(name + ": " + defect.sentence() + ".");
  return description;
}

Expected<Description> read_description(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, kMaxDescriptionBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_description(*text, path);
}

}  // namespace tenter::capture
