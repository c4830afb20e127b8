// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <map>

#include "common/capture/file/layout.h"
#include "common/capture/sheet/sheet_file.h"

namespace tenter::capture {

namespace {

using namespace layout;

template <std::size_t N>
std::vector<std::array<double, N>> rows_of(const std::vector<double>& values) {
  std::vector<std::array<double, N>> rows(values.size() / N);
  for (std::size_t i = 0; i < rows.size() * N; ++i) rows[i / N][i % N] = values[i];
  return rows;
}

template <std::size_t N>
std::array<double, N> vector_of(Source& in, const std::string& path, const std::string& unit) {
  in.check_unit(path, unit);
  const auto rows = rows_of<N>(in.table(path, {N}).values);
  return rows.empty() ? std::array<double, N>{} : rows.front();
}

std::vector<double> table_of(Source& in, const std::string& path,
                             const std::vector<std::uint64_t>& shape, const std::string& unit) {
  in.check_unit(path, unit);
  return in.table(path, shape).values;
}

/// Groups of `path` in the order that they name themselves.
std::vector<std::string> in_order(Source& in, const std::string& path,
                                  std::vector<std::string>* ignored) {
  std::map<std::int64_t, std::string> ordered;
  for (const std::string& name : in.members(path)) {
    const std::string member = path + "/" + name;
    if (!in.has_attribute(member, "order")) {
      ignored->push_back(member);
      continue;
    }
    if (!ordered.emplace(in.integer_attribute(member, "order"), name).second)
      in.complain(member, "has the order of another one");
  }
  std::vector<std::string> names;
  names.reserve(ordered.size());
  for (const auto& [order, name] : ordered) names.push_back(name);
  return names;
}

std::vector<RigidPose> read_poses(Source& in, const std::string& path, std::size_t frames) {
  const auto position = rows_of<3>(table_of(in, path + "/position", {frames, 3}, "m"));
  const auto rotation = rows_of<4>(table_of(in, path + "/rotation", {frames, 4}, "1"));
  std::vector<RigidPose> poses(in.ok() ? frames : 0);
  for (std::size_t f = 0; f < poses.size(); ++f) poses[f] = {position[f], rotation[f]};
  return poses;
}

std::vector<std::array<int, 3>> read_triangles(Source& in, const std::string& path) {
  std::vector<std::array<int, 3>> triangles;
  for (const auto& row : rows_of<3>(in.table(path, {0, 3}).values)) {
    std::array<int, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      const bool fits =
          row[c] == std::floor(row[c]) && std::abs(row[c]) < std::numeric_limits<int>::max();
      if (!fits) {
        in.complain(path, "holds a corner that is no vertex number");
        return {};
      }
      corners[c] = static_cast<int>(row[c]);
    }
    triangles.push_back(corners);
  }
  return triangles;
}

void read_mesh(Source& in, Sheet& sheet, std::size_t frames, std::vector<std::string>* ignored) {
  const std::vector<std::string> names = in_order(in, kMeshes, ignored);
  if (in.ok() && names.size() != 1)
    return in.complain(kMeshes, "must hold one mesh, not " + std::to_string(names.size()));
  if (!in.ok()) return;
  sheet.name = names.front();
  const std::string path = kMeshes + "/" + sheet.name;
  sheet.material_m = rows_of<2>(table_of(in, path + "/material", {0, 2}, "m"));
  const std::string positions = path + "/position";
  in.check_unit(positions, "m");
  const std::uint64_t vertices = sheet.vertex_count();
  if (in.ok() && vertices == 0) return in.complain(path + "/material", "has no vertices");
  h5::H5Reader::Table table = in.table(positions, {frames, vertices, 0});
  if (!in.ok()) return;
  if (table.shape[2] != 2 && table.shape[2] != 3)
    return in.complain(positions, "must have 2 or 3 coordinates");
  sheet.coordinates = static_cast<int>(table.shape[2]);
  sheet.position_m = std::move(table.values);
  sheet.sigma_m = in.number_attribute(positions, "sigma");
  sheet.may_be_missing = in.integer_attribute(positions, "may_be_missing") != 0;
  if (in.has(path + "/connectivity")) sheet.triangles = read_triangles(in, path + "/connectivity");
  if (in.has(path + "/outline"))
    sheet.outline_m = rows_of<2>(table_of(in, path + "/outline", {0, 2}, "m"));
  if (in.has(path + "/vertex_name")) sheet.vertex_name = in.texts(path + "/vertex_name");
  if (in.has(path + "/vertex_sigma"))
    sheet.sigma_per_vertex_m = table_of(in, path + "/vertex_sigma", {vertices}, "m");
  list_ignored(in, path,
               {"position", "material", "connectivity", "outline", "vertex_name", "vertex_sigma"},
               ignored);
}

/// One of two words.
bool is_first(Source& in, const std::string& path, const std::string& first,
              const std::string& second) {
  const std::string word = in.text(path);
  if (in.ok() && word != first && word != second)
    in.complain(path, "is \"" + word + "\", not one of " + first + ", " + second);
  return word == first;
}

ClipTrack read_clip(Source& in, const std::string& id, std::size_t frames,
                    std::vector<std::string>* ignored) {
  const std::string path = kClips + "/" + id;
  ClipTrack clip;
  clip.id = id;
  clip.pose = read_poses(in, path, frames);
  clip.is_free = is_first(in, path + "/role", "free", "prescribed");
  if (in.has(path + "/region"))
    clip.region_m = rows_of<2>(table_of(in, path + "/region", {0, 2}, "m"));
  if (in.has(path + "/vertices")) clip.vertices = in.ints(path + "/vertices");
  in.check_unit(path + "/mass", "kg");
  clip.mass_kg = in.number(path + "/mass");
  clip.centre_of_mass_m = vector_of<3>(in, path + "/centre_of_mass", "m");
  clip.grip.position_m = vector_of<3>(in, path + "/grip_position", "m");
  clip.grip.rotation = vector_of<4>(in, path + "/grip_rotation", "1");
  list_ignored(in, path,
               {"position", "rotation", "role", "region", "vertices", "mass", "centre_of_mass",
                "grip_position", "grip_rotation"},
               ignored);
  return clip;
}

CordTrack read_cord(Source& in, const std::string& id, std::size_t frames,
                    std::vector<std::string>* ignored) {
  const std::string path = kCords + "/" + id;
  CordTrack cord;
  cord.id = id;
  cord.clip = in.text(path + "/clip");
  cord.attachment_m = vector_of<3>(in, path + "/attachment", "m");
  cord.tension_N = table_of(in, path + "/tension", {frames}, "N");
  cord.sigma_N = in.number_attribute(path + "/tension", "sigma");
  cord.may_be_missing = in.integer_attribute(path + "/tension", "may_be_missing") != 0;
  cord.direction = rows_of<3>(table_of(in, path + "/direction", {frames, 3}, "1"));
  list_ignored(in, path, {"clip", "attachment", "tension", "direction"}, ignored);
  return cord;
}

SupportTrack read_support(Source& in, const std::string& id, std::size_t frames,
                          std::vector<std::string>* ignored) {
  const std::string path = kSupports + "/" + id;
  SupportTrack support;
  support.id = id;
  support.edge_m = table_of(in, path + "/edge", {frames}, "m");
  support.along = is_first(in, path + "/along", "u", "v") ? 'u' : 'v';
  support.bears_above = is_first(in, path + "/bears", "above", "below");
  support.pose = read_poses(in, path, frames);
  list_ignored(in, path, {"edge", "along", "bears", "position", "rotation"}, ignored);
  return support;
}

SlackRule read_slack(Source& in, std::vector<std::string>* ignored) {
  SlackRule slack;
  const std::vector<std::string> clips = in.texts(kSlack + "/clips");
  if (in.ok() && clips.size() != slack.clips.size())
    in.complain(kSlack + "/clips", "must name two clips");
  if (in.ok()) slack.clips = {clips[0], clips[1]};
  in.check_unit(kSlack + "/closer_than", "m");
  slack.closer_than_m = in.number(kSlack + "/closer_than");
  list_ignored(in, kSlack, {"clips", "closer_than"}, ignored);
  return slack;
}

}  // namespace

Sheet read_sheet(Source& in, std::size_t frames, std::vector<std::string>* ignored) {
  Sheet sheet;
  if (frames == 0) {  // 0 would stand for any length below
    in.complain(kEntry, "has no frames");
    return sheet;
  }
  read_mesh(in, sheet, frames, ignored);
  for (const std::string& id : in_order(in, kClips, ignored)) {
    if (!in.ok()) return sheet;
    sheet.clips.push_back(read_clip(in, id, frames, ignored));
  }
  for (const std::string& id : in_order(in, kCords, ignored)) {
    if (!in.ok()) return sheet;
    sheet.cords.push_back(read_cord(in, id, frames, ignored));
  }
  for (const std::string& id : in_order(in, kSupports, ignored)) {
    if (!in.ok()) return sheet;
    sheet.supports.push_back(read_support(in, id, frames, ignored));
  }
  if (in.ok() && in.has(kSlack)) sheet.slack = read_slack(in, ignored);
  sheet.gravity_m_s2 = vector_of<3>(in, kGravity, "m/s^2");
  return sheet;
}

}  // namespace tenter::capture
