// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet_import/sheet_description.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/capture/csv/description_parts.h"
#include "common/capture/sheet_import/sheet_rest.h"
#include "common/capture/strict_json.h"

namespace tenter::capture {

namespace {

using Uses = std::vector<std::string>;

bool is_number_list(const nlohmann::json& value, std::size_t count) {
  return value.is_array() && value.size() == count &&
         std::all_of(value.begin(), value.end(), [](const nlohmann::json& v) {
           return v.is_number() && std::isfinite(v.get<double>());
         });
}

template <std::size_t N>
std::array<double, N> list_of(const nlohmann::json& value) {
  std::array<double, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) numbers[i] = value[i].get<double>();
  return numbers;
}

template <std::size_t N>
std::optional<std::array<double, N>> maybe_list(JsonObject& object, const std::string& key) {
  const nlohmann::json* value = object.raw(key);
  if (!value) return std::nullopt;
  if (is_number_list(*value, N)) return list_of<N>(*value);
  object.defect().note(object.path_of(key), "must be a list of " + std::to_string(N) + " numbers");
  return std::nullopt;
}

UnitConversion unit(JsonObject& object, const std::string& si_unit) {
  const Expected<UnitConversion> to_si = conversion(object.text("unit"), si_unit);
  if (to_si) return *to_si;
  if (object.has("unit")) object.defect().note(object.path_of("unit") + ":", to_si.error().message);
  return {};
}

template <std::size_t N>
std::array<double, N> in_si(std::array<double, N> values, const UnitConversion& to_si) {
  for (double& value : values) value = to_si.apply(value);
  return values;
}

void read_uses(JsonObject columns, const Uses& known, std::map<std::string, std::string>& out) {
  for (const std::string& use : columns.keys()) {
    if (std::find(known.begin(), known.end(), use) == known.end()) {
      std::string words;
      for (const std::string& word : known) words += (words.empty() ? "" : ", ") + word;
      columns.defect().note(columns.path_of(use), "is not one of " + words);
    }
    out[use] = columns.text(use);
  }
}

/// One of two words: is it the first?
bool is_first(JsonObject& object, const std::string& key, const std::string& first,
              const std::string& second, const std::string& otherwise) {
  const std::string word = object.text_or(key, otherwise);
  if (word != first && word != second)
    object.defect().note(object.path_of(key), "must be \"" + first + "\" or \"" + second + "\"");
  return word == first;
}

/// The keys that every table has.
TableSpec read_table(JsonObject& object, const std::string& key, const Uses& known,
                     const std::string& si_unit) {
  TableSpec table;
  table.key = key;
  table.file = object.text_or("file", "");
  Description options;
  read_file_options(object, options);
  table.csv = options.csv;
  table.decimal_comma = options.decimal_comma;
  table.where = options.where;
  if (!si_unit.empty()) table.to_si = unit(object, si_unit);
  table.may_be_missing = is_first(object, "missing", "allowed", "error", "error");
  table.ignore_other_frames = is_first(object, "other_frames", "ignore", "error", "error");
  if (object.has("columns")) read_uses(object.object("columns"), known, table.columns);
  return table;
}

void require(JsonObject& object, const TableSpec& table, const Uses& needed) {
  for (const std::string& use : needed)
    if (!table.has(use)) object.defect().note(object.path_of("columns") + "." + use, "is missing");
}

const Uses kPoseUses = {"run", "frame", "x", "y", "z", "qw", "qx", "qy", "qz"};

/// A constant pose, a table of poses, or a table whose missing columns are constant.
PoseSpec read_pose(JsonObject object) {
  PoseSpec pose;
  const bool has_lengths = object.has("position") || object.has("columns");
  if (object.has("columns"))
    pose.table = read_table(object, object.path_of("columns"), kPoseUses, "m");
  const UnitConversion to_m = pose.table    ? pose.table->to_si
                              : has_lengths ? unit(object, "m")
                                            : UnitConversion{};
  if (const auto position = maybe_list<3>(object, "position"))
    pose.constant.position_m = in_si(*position, to_m);
  if (const auto rotation = maybe_list<4>(object, "rotation")) pose.constant.rotation = *rotation;
  if (pose.table) {
    require(object, *pose.table, {"frame"});
    const auto quaternions =
        std::count_if(kPoseUses.begin() + 5, kPoseUses.end(),
                      [&](const std::string& use) { return pose.table->has(use); });
    if (quaternions != 0 && quaternions != 4)
      object.defect().note(object.path_of("columns"), "must name all of qw, qx, qy, qz or none");
  }
  object.finish();
  return pose;
}

/// {"unit": "mm", "box": [[u0, v0], [u1, v1]]} or {"unit": "mm", "polygon": [[u, v], ...]}.
std::vector<Vec2> read_region(JsonObject object) {
  const UnitConversion to_m = unit(object, "m");
  std::vector<Vec2> corners;
  for (const char* key : {"box", "polygon"}) {
    const nlohmann::json* value = object.raw(key);
    if (!value) continue;
    const bool is_list =
        corners.empty() && value->is_array() &&
        std::all_of(value->begin(), value->end(),
                    [](const nlohmann::json& corner) { return is_number_list(corner, 2); });
    if (!is_list || value->size() < 2 || (key == std::string("box") && value->size() != 2)) {
      object.defect().note(object.path_of(key), "must be a list of corners [u, v], two of a box");
      continue;
    }
    for (const nlohmann::json& corner : *value) corners.push_back(in_si(list_of<2>(corner), to_m));
    if (key == std::string("box")) {
      const Vec2 lo = corners[0], hi = corners[1];
      corners = {lo, {hi[0], lo[1]}, hi, {lo[0], hi[1]}};
    }
  }
  if (corners.empty()) object.defect().note(object.path_of("box"), "or polygon is missing");
  object.finish();
  return corners;
}

std::optional<Vec3> maybe_place(JsonObject& object, const std::string& key) {
  std::optional<JsonObject> place = object.maybe_object(key);
  if (!place) return std::nullopt;
  const UnitConversion to_m = unit(*place, "m");
  const auto at = maybe_list<3>(*place, "at");
  if (!at) place->defect().note(place->path_of("at"), "must be a list of 3 numbers");
  place->finish();
  return in_si(at.value_or(Vec3{}), to_m);
}

ClipSpec read_clip(JsonObject& object) {
  ClipSpec clip;
  clip.track.id = object.text("id");
  clip.track.is_free = is_first(object, "role", "free", "prescribed", "");
  if (std::optional<JsonObject> region = object.maybe_object("region"))
    clip.track.region_m = read_region(*region);
  clip.vertices = object.texts("vertices");
  clip.track.mass_kg = object.maybe_measure("mass", "kg").value_or(0.0);
  clip.track.centre_of_mass_m = maybe_place(object, "centre_of_mass").value_or(Vec3{});
  if (const nlohmann::json* grip = object.raw("grip"); grip && *grip == "first_frame")
    clip.grip_from_first_frame = true;
  else if (grip)
    clip.track.grip = read_pose(object.object("grip")).constant;
  clip.pose = read_pose(object.object("pose"));
  object.finish();
  return clip;
}

CordSpec read_cord(JsonObject& object) {
  CordSpec cord;
  cord.track.id = object.text("id");
  cord.track.clip = object.text("clip");
  cord.track.attachment_m = maybe_place(object, "attachment").value_or(Vec3{});
  JsonObject tension = object.object("tension");
  cord.tension = read_table(tension, tension.path_of("columns"),
                            {"run", "frame", "tension", "over", "dx", "dy", "dz"}, "N");
  const UnitConversion& to_N = cord.tension.to_si;
  cord.track.sigma_N = to_N.apply_to_difference(tension.maybe_number("sigma").value_or(0.0));
  cord.track.may_be_missing = cord.tension.may_be_missing;
  require(tension, cord.tension, {"tension"});
  if (std::optional<JsonObject> over = tension.maybe_object("over")) {
    cord.over = CordSpec::Over{};
    cord.over->clip = over->text("clip");
    const std::string coordinate = over->text("coordinate");
    const std::size_t index = std::string("xyz").find(coordinate);
    if (coordinate.size() != 1 || index == std::string::npos)
      over->defect().note(over->path_of("coordinate"), "must be \"x\", \"y\" or \"z\"");
    cord.over->coordinate = std::min<std::size_t>(index, 2);
    cord.over->to_m = unit(*over, "m");
    over->finish();
    require(tension, cord.tension, {"over"});
  } else {
    require(tension, cord.tension, {"frame"});
  }
  tension.finish();
  const bool has_columns = cord.tension.has("dx") || cord.tension.has("dy");
  if (has_columns) require(tension, cord.tension, {"dx", "dy", "dz"});
  if (has_columns && cord.over)
    tension.defect().note(tension.path_of("columns"), "gives directions, which need a frame");
  if (const auto direction = maybe_list<3>(object, "direction")) {
    const double length = std::hypot((*direction)[0], (*direction)[1], (*direction)[2]);
    if (!(length > 0.0)) object.defect().note(object.path_of("direction"), "has no length");
    cord.direction = *direction;
    if (std::abs(length - 1.0) > 1e-12)
      for (double& d : cord.direction) d /= length;
  } else if (!has_columns) {
    object.defect().note(object.path_of("direction"), "is missing");
  }
  object.finish();
  return cord;
}

SupportSpec read_support(JsonObject& object) {
  SupportSpec support;
  support.track.id = object.text("id");
  support.track.along = is_first(object, "along", "u", "v", "") ? 'u' : 'v';
  support.track.bears_above = is_first(object, "bears", "above", "below", "");
  JsonObject edge = object.object("edge");
  if (edge.has("columns")) {
    support.edge = read_table(edge, edge.path_of("columns"), {"run", "frame", "edge"}, "m");
    require(edge, *support.edge, {"frame", "edge"});
  } else {
    const UnitConversion to_m = unit(edge, "m");
    support.edge_m = to_m.apply(edge.number("value"));
  }
  edge.finish();
  if (object.has("pose")) support.pose = read_pose(object.object("pose"));
  object.finish();
  return support;
}

MeshSpec read_mesh(JsonObject object) {
  MeshSpec mesh;
  mesh.file = object.text_or("file", "");
  const double first = object.maybe_number("first_vertex").value_or(0.0);
  if (first != 0.0 && first != 1.0)
    object.defect().note(object.path_of("first_vertex"), "must be 0 or 1");
  mesh.first_vertex = static_cast<int>(first);
  if (!mesh.file.empty()) {
    mesh.metres_per_unit = unit(object, "m").apply_to_difference(1.0);
    mesh.metres_per_texture_unit = mesh.metres_per_unit;
    if (const auto texture = object.maybe_measure("texture_unit", "m"))
      mesh.metres_per_texture_unit = *texture;
  } else {
    JsonObject vertices = object.object("vertices");
    mesh.vertices =
        read_table(vertices, vertices.path_of("columns"), {"vertex", "u", "v", "sigma"}, "m");
    require(vertices, *mesh.vertices, {"u", "v"});
    vertices.finish();
    if (std::optional<JsonObject> triangles = object.maybe_object("triangles")) {
      mesh.triangles = read_table(*triangles, triangles->path_of("columns"), {"a", "b", "c"}, "");
      require(*triangles, *mesh.triangles, {"a", "b", "c"});
      triangles->finish();
    }
  }
  object.finish();
  return mesh;
}

const Uses kCoordinates = {"x", "y", "z", "dx", "dy", "dz"};

void read_positions(JsonObject object, SheetDescription& out) {
  Uses uses = {"run", "frame", "vertex", "u", "v"};
  uses.insert(uses.end(), kCoordinates.begin(), kCoordinates.end());
  out.positions = read_table(object, object.path_of("columns"), uses, "m");
  const UnitConversion& to_m = out.positions.to_si;
  out.head.may_be_missing = out.positions.may_be_missing;
  out.head.sigma_m = to_m.apply_to_difference(object.maybe_number("sigma").value_or(0.0));
  const std::string material = object.text_or("material", "");
  out.material_from_first_frame = material == "first_frame";
  out.material_from_rest = material == "rest";
  if (!material.empty() && !out.is_material_seen())
    object.defect().note(object.path_of("material"), "must be \"first_frame\" or \"rest\"");
  for (JsonObject& item : object.objects("points")) {
    PointSpec point;
    point.name = item.text("name");
    if (const auto place = maybe_list<2>(item, "material")) point.material_m = in_si(*place, to_m);
    if (point.material_m.has_value() == out.is_material_seen())
      item.defect().note(
          item.path_of("material"),
          out.is_material_seen() ? "contradicts \"material\": \"" + material + "\"" : "is missing");
    read_uses(item.object("columns"), kCoordinates, point.columns);
    item.finish();
    out.points.push_back(std::move(point));
  }
  require(object, out.positions, {"frame"});
  if (out.points.empty()) require(object, out.positions, {"vertex"});
  if (!out.points.empty() && out.positions.has("vertex"))
    object.defect().note(object.path_of("columns"),
                         "name a vertex, but the points have columns of their own");
  object.finish();
}

/// Where the frames are: a table of their own, or that of the positions.
void read_frames(JsonObject& root, SheetDescription& out) {
  Description& frames = out.frames;
  frames.rows_repeat_frames = true;
  frames.ignore_other_columns = true;
  std::optional<JsonObject> object = root.maybe_object("frames");
  if (!object) {
    for (const auto& [use, is] : {std::pair{"run", &ColumnDescription::is_run},
                                  std::pair{"frame", &ColumnDescription::is_frame}}) {
      if (!out.positions.has(use)) continue;
      ColumnDescription column;
      column.csv = out.positions.columns.at(use);
      column.*is = true;
      frames.columns.push_back(column);
    }
    frames.csv = out.positions.csv;
    frames.decimal_comma = out.positions.decimal_comma;
    frames.where = out.positions.where;
    out.frames_file = out.positions.file;
    return;
  }
  out.are_frames_given = true;
  out.frames_file = object->text_or("file", "");
  read_file_options(*object, frames);
  frames.ignore_other_columns = true;
  JsonObject columns = object->object("columns");
  for (const std::string& name : columns.keys()) {
    frames.columns.push_back(read_column(columns, name));
    if (frames.columns.back().is_channel)
      columns.defect().note(columns.path_of(name), "is a channel, which a sheet does not have");
  }
  check_columns(frames, root.defect());
  object->finish();
}

void read_root(JsonObject& root, SheetDescription& out) {
  if (const std::string schema = root.text_or("schema", "tenter.describe");
      schema != "tenter.describe")
    root.defect().note("schema", "is \"" + schema + "\", not \"tenter.describe\"");
  if (root.maybe_number("version").value_or(1.0) != 1.0) root.defect().note("version", "must be 1");
  Capture& head = out.frames.head;
  head.kind = root.text("kind");
  if (head.kind != "deforming_sheet")
    root.defect().note("kind", "must be \"deforming_sheet\" here");
  head.title = root.text("title");
  read_specimen(root.object("specimen"), head.specimen);
  read_protocol(root.object("protocol"), out.frames);
  read_provenance(root.object("provenance"), out.frames);
  out.head.name = root.text_or("name", "sheet");
  if (std::optional<JsonObject> mesh = root.maybe_object("mesh")) out.mesh = read_mesh(*mesh);
  if (std::optional<JsonObject> outline = root.maybe_object("outline"))
    out.head.outline_m = read_region(*outline);
  read_positions(root.object("positions"), out);
  read_frames(root, out);
  check_protocol_against_columns(out.frames, root.defect());
  for (JsonObject& clip : root.objects("clips")) out.clips.push_back(read_clip(clip));
  for (JsonObject& cord : root.objects("cords")) out.cords.push_back(read_cord(cord));
  for (JsonObject& support : root.objects("supports"))
    out.supports.push_back(read_support(support));
  if (const auto gravity = maybe_list<3>(root, "gravity_m_s2"))
    out.head.gravity_m_s2 = *gravity;
  else
    root.defect().note("gravity_m_s2",
                       "is missing: three numbers, all 0 where the weight does not count");
  const int materials =
      (out.mesh ? 1 : 0) + (out.positions.has("u") ? 1 : 0) + (out.is_material_seen() ? 1 : 0);
  if (materials > 1 || (materials == 1 && !out.points.empty() && !out.is_material_seen()))
    root.defect().note("positions", "have their places in the material from two sources");
  if (materials == 0 && out.points.empty())
    root.defect().note("positions",
                       "have no places in the material: a mesh, columns u and v, or \"material\" "
                       "must give them");
  if (std::optional<JsonObject> rest = root.maybe_object("rest")) out.rest = read_rest(*rest);
  if (out.material_from_rest && (!out.rest || out.rest->read_at_m == 0.0))
    root.defect().note("rest.read_at", "is missing: it says where places in the material are read");
  root.finish();
}

}  // namespace

Expected<SheetDescription> parse_sheet_description(const std::string& text,
                                                   const std::string& name) {
  const Expected<nlohmann::json> document = parse_json(text, name);
  if (!document) return tl::unexpected(document.error());
  JsonDefect defect;
  JsonObject root(*document, "", defect);
  SheetDescription description;
  read_root(root, description);
  if (defect) return bad_input(name + ": " + defect.sentence() + ".");
  return description;
}

bool describes_sheet(const std::string& text) {
  const nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  return document.is_object() && document.value("kind", nlohmann::json()) == "deforming_sheet";
}

}  // namespace tenter::capture
