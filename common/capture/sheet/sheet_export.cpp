// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet/sheet_export.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/atomic_write.h"
#include "common/capture/csv/csv_export_parts.h"
#include "common/capture/csv/csv_table.h"

namespace tenter::capture {

namespace {

using nlohmann::ordered_json;

template <std::size_t N>
std::string cells(const std::array<double, N>& values) {
  std::string text;
  for (const double value : values) text += "," + csv_number(value);
  return text;
}

std::string run_and_frame(const Capture& capture, std::size_t f) {
  return std::to_string(capture.runs[static_cast<std::size_t>(capture.run[f])].number) + "," +
         std::to_string(capture.frame[f]);
}

std::string vertex_label(const Sheet& sheet, std::size_t k) {
  return sheet.vertex_name.empty() ? std::to_string(k) : sheet.vertex_name[k];
}

std::string vertices_csv(const Sheet& sheet) {
  const bool sigma = !sheet.sigma_per_vertex_m.empty();
  std::string csv = std::string("vertex,u,v") + (sigma ? ",sigma\n" : "\n");
  for (std::size_t k = 0; k < sheet.vertex_count(); ++k)
    csv += vertex_label(sheet, k) + cells(sheet.material_m[k]) +
           (sigma ? "," + csv_number(sheet.sigma_per_vertex_m[k]) : "") + "\n";
  return csv;
}

std::string triangles_csv(const Sheet& sheet) {
  std::string csv = "a,b,c\n";
  for (const auto& [a, b, c] : sheet.triangles)
    csv += vertex_label(sheet, static_cast<std::size_t>(a)) + "," +
           vertex_label(sheet, static_cast<std::size_t>(b)) + "," +
           vertex_label(sheet, static_cast<std::size_t>(c)) + "\n";
  return csv;
}

std::string positions_csv(const Capture& capture, const Sheet& sheet) {
  std::string csv = sheet.coordinates == 3 ? "run,frame,vertex,x,y,z\n" : "run,frame,vertex,x,y\n";
  for (std::size_t f = 0; f < capture.frame_count(); ++f)
    for (std::size_t k = 0; k < sheet.vertex_count(); ++k) {
      csv += run_and_frame(capture, f) + "," + vertex_label(sheet, k);
      for (std::size_t c = 0; c < static_cast<std::size_t>(sheet.coordinates); ++c)
        csv += "," + csv_number(sheet.position_m[sheet.at(f, k) + c]);
      csv += "\n";
    }
  return csv;
}

std::string pose_row(const Capture& capture, const std::string& body, const RigidPose& pose,
                     std::size_t f) {
  return body + "," + run_and_frame(capture, f) + cells(pose.position_m) + cells(pose.rotation);
}

constexpr const char* kPoseHeader = "body,run,frame,x,y,z,qw,qx,qy,qz";

std::string clips_csv(const Capture& capture, const Sheet& sheet) {
  std::string csv = std::string(kPoseHeader) + "\n";
  for (const ClipTrack& clip : sheet.clips)
    for (std::size_t f = 0; f < clip.pose.size(); ++f)
      csv += pose_row(capture, clip.id, clip.pose[f], f) + "\n";
  return csv;
}

std::string supports_csv(const Capture& capture, const Sheet& sheet) {
  std::string csv = std::string(kPoseHeader) + ",edge\n";
  for (const SupportTrack& support : sheet.supports)
    for (std::size_t f = 0; f < support.pose.size(); ++f)
      csv += pose_row(capture, support.id, support.pose[f], f) + "," +
             csv_number(support.edge_m[f]) + "\n";
  return csv;
}

std::string cords_csv(const Capture& capture, const Sheet& sheet) {
  std::string csv = "cord,run,frame,tension,dx,dy,dz\n";
  for (const CordTrack& cord : sheet.cords)
    for (std::size_t f = 0; f < cord.tension_N.size(); ++f)
      csv += cord.id + "," + run_and_frame(capture, f) + "," + csv_number(cord.tension_N[f]) +
             cells(cord.direction[f]) + "\n";
  return csv;
}

/// The sheet at rest: places and texture coordinates both are (u, v).
std::string reference_obj(const Sheet& sheet) {
  std::string obj = "# the sheet at rest, in metres; texture coordinates are u = weft, v = warp\n";
  for (const Vec2& place : sheet.material_m)
    obj += "v " + csv_number(place[0]) + " " + csv_number(place[1]) + " 0\n";
  for (const Vec2& place : sheet.material_m)
    obj += "vt " + csv_number(place[0]) + " " + csv_number(place[1]) + "\n";
  for (const auto& triangle : sheet.triangles) {
    obj += "f";
    for (const int corner : triangle) {
      const std::string number = std::to_string(corner + 1);
      obj += " " + number + "/" + number;
    }
    obj += "\n";
  }
  return obj;
}

/// {"a": "a", "b": "b"}: the columns are called what they are for.
ordered_json uses(std::initializer_list<const char*> names) {
  ordered_json columns;
  for (const char* name : names) columns[name] = name;
  return columns;
}

ordered_json place(const Vec3& at) {
  return {{"unit", "m"}, {"at", at}};
}

ordered_json pose_table(const std::string& file, const std::string& body) {
  return {{"file", file},
          {"unit", "m"},
          {"where", {{"body", body}}},
          {"columns", uses({"run", "frame", "x", "y", "z", "qw", "qx", "qy", "qz"})}};
}

ordered_json describe_clip(const Sheet& sheet, const ClipTrack& clip, const std::string& stem) {
  ordered_json out = {{"id", clip.id}, {"role", clip.is_free ? "free" : "prescribed"}};
  if (!clip.region_m.empty()) out["region"] = {{"unit", "m"}, {"polygon", clip.region_m}};
  if (!clip.vertices.empty()) {
    out["vertices"] = ordered_json::array();
    for (const int vertex : clip.vertices)
      out["vertices"].push_back(vertex_label(sheet, static_cast<std::size_t>(vertex)));
  }
  out["mass"] = {{"value", clip.mass_kg}, {"unit", "kg"}};
  out["centre_of_mass"] = place(clip.centre_of_mass_m);
  out["grip"] = {
      {"unit", "m"}, {"position", clip.grip.position_m}, {"rotation", clip.grip.rotation}};
  out["pose"] = pose_table(stem + "_clips.csv", clip.id);
  return out;
}

ordered_json describe_cord(const CordTrack& cord, const std::string& stem) {
  ordered_json tension = {{"file", stem + "_cords.csv"},
                          {"unit", "N"},
                          {"where", {{"cord", cord.id}}},
                          {"columns", uses({"run", "frame", "tension", "dx", "dy", "dz"})}};
  if (cord.sigma_N > 0.0) tension["sigma"] = cord.sigma_N;
  if (cord.may_be_missing) tension["missing"] = "allowed";
  return {{"id", cord.id},
          {"clip", cord.clip},
          {"attachment", place(cord.attachment_m)},
          {"tension", tension}};
}

ordered_json describe_support(const SupportTrack& support, const std::string& stem) {
  const std::string file = stem + "_supports.csv";
  return {{"id", support.id},
          {"along", std::string(1, support.along)},
          {"bears", support.bears_above ? "above" : "below"},
          {"edge",
           {{"file", file},
            {"unit", "m"},
            {"where", {{"body", support.id}}},
            {"columns", uses({"run", "frame", "edge"})}}},
          {"pose", pose_table(file, support.id)}};
}

ordered_json describe_mesh(const Sheet& sheet, const std::string& stem) {
  ordered_json columns = uses({"u", "v"});
  if (!sheet.vertex_name.empty()) columns["vertex"] = "vertex";
  if (!sheet.sigma_per_vertex_m.empty()) columns["sigma"] = "sigma";
  ordered_json mesh;
  mesh["vertices"] = {{"file", stem + "_vertices.csv"}, {"unit", "m"}, {"columns", columns}};
  if (!sheet.triangles.empty())
    mesh["triangles"] = {{"file", stem + "_triangles.csv"}, {"columns", uses({"a", "b", "c"})}};
  return mesh;
}

std::string description_of(const Capture& capture, const std::string& stem) {
  const Sheet& sheet = *capture.sheet;
  ordered_json root;
  root["schema"] = "tenter.describe";
  root["version"] = 1;
  root["kind"] = capture.kind;
  root["title"] = capture.title;
  root["name"] = sheet.name;
  root["specimen"] = describe_specimen(capture.specimen);
  root["protocol"] = describe_protocol(capture.protocol);
  root["provenance"] = describe_provenance(capture.provenance);
  root["frames"] = {{"file", stem + "_frames.csv"}, {"columns", describe_columns(capture)}};
  root["mesh"] = describe_mesh(sheet, stem);
  ordered_json columns = uses({"run", "frame", "vertex", "x", "y"});
  if (sheet.coordinates == 3) columns["z"] = "z";
  root["positions"] = {
      {"file", stem + "_positions.csv"}, {"unit", "m"}, {"columns", std::move(columns)}};
  if (sheet.sigma_m > 0.0) root["positions"]["sigma"] = sheet.sigma_m;
  if (sheet.may_be_missing) root["positions"]["missing"] = "allowed";
  if (!sheet.outline_m.empty()) root["outline"] = {{"unit", "m"}, {"polygon", sheet.outline_m}};
  root["clips"] = ordered_json::array();
  for (const ClipTrack& clip : sheet.clips)
    root["clips"].push_back(describe_clip(sheet, clip, stem));
  root["cords"] = ordered_json::array();
  for (const CordTrack& cord : sheet.cords) root["cords"].push_back(describe_cord(cord, stem));
  root["supports"] = ordered_json::array();
  for (const SupportTrack& support : sheet.supports)
    root["supports"].push_back(describe_support(support, stem));
  if (sheet.slack)
    root["rest"] = {{"clips", sheet.slack->clips},
                    {"slack_below", {{"value", sheet.slack->closer_than_m}, {"unit", "m"}}}};
  root["gravity_m_s2"] = sheet.gravity_m_s2;
  return root.dump(2) + "\n";
}

}  // namespace

std::vector<ExportedFile> sheet_files(const Capture& capture, const std::string& stem) {
  const Sheet& sheet = *capture.sheet;
  std::vector<ExportedFile> files = {{stem + ".json", description_of(capture, stem)},
                                     {stem + "_frames.csv", table_of(capture)},
                                     {stem + "_vertices.csv", vertices_csv(sheet)},
                                     {stem + "_positions.csv", positions_csv(capture, sheet)}};
  if (!sheet.triangles.empty()) {
    files.push_back({stem + "_triangles.csv", triangles_csv(sheet)});
    files.push_back({stem + ".obj", reference_obj(sheet)});
  }
  if (!sheet.clips.empty()) files.push_back({stem + "_clips.csv", clips_csv(capture, sheet)});
  if (!sheet.cords.empty()) files.push_back({stem + "_cords.csv", cords_csv(capture, sheet)});
  if (!sheet.supports.empty())
    files.push_back({stem + "_supports.csv", supports_csv(capture, sheet)});
  return files;
}

Expected<std::vector<std::string>> export_sheet(const Capture& capture,
                                                const std::string& describe_path, bool replace) {
  namespace fs = std::filesystem;
  const fs::path describe(describe_path);
  std::vector<ExportedFile> files = sheet_files(capture, describe.stem().string());
  files.front().name = describe.filename().string();
  std::vector<std::string> paths;
  for (const ExportedFile& file : files) {
    paths.push_back((describe.parent_path() / file.name).string());
    std::error_code ignored;
    if (!replace && fs::exists(paths.back(), ignored))
      return fail(ErrorKind::refused, paths.back() + ": exists; --force replaces it");
  }
  for (std::size_t i = 0; i < files.size(); ++i)
    if (auto ok = write_atomically(paths[i], files[i].text.data(), files[i].text.size()); !ok)
      return tl::unexpected(ok.error());
  return paths;
}

}  // namespace tenter::capture
