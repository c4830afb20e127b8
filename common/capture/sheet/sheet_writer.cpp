// SPDX-License-Identifier: Apache-2.0
#include "common/capture/file/layout.h"
#include "common/capture/sheet/sheet_file.h"

namespace tenter::capture {

namespace {

using h5::H5Writer;
using namespace layout;

std::vector<double> flat(const Vec3& v) {
  return {v.begin(), v.end()};
}

template <std::size_t N>
std::vector<double> flat(const std::vector<std::array<double, N>>& rows) {
  std::vector<double> values;
  values.reserve(rows.size() * N);
  for (const auto& row : rows) values.insert(values.end(), row.begin(), row.end());
  return values;
}

/// A group of plots over the frames.
void plot_group(H5Writer& file, const std::string& path, const std::string& signal,
                std::size_t dimensions, std::size_t order) {
  file.group(path, "NXdata");
  file.attribute(path, "signal", signal);
  file.attribute(path, "axes", std::vector<std::string>(dimensions, "."));
  file.attribute(path, "order", static_cast<std::int64_t>(order));
}

void write_poses(H5Writer& file, const std::string& path, const std::vector<RigidPose>& poses) {
  std::vector<double> position, rotation;
  for (const RigidPose& pose : poses) {
    position.insert(position.end(), pose.position_m.begin(), pose.position_m.end());
    rotation.insert(rotation.end(), pose.rotation.begin(), pose.rotation.end());
  }
  file.array(path + "/position", position, {poses.size(), 3}, "m");
  file.array(path + "/rotation", rotation, {poses.size(), 4}, "1");
}

void write_mesh(H5Writer& file, const Sheet& sheet, std::size_t frames) {
  file.group(kMeshes, "NXcollection");
  file.attribute(kMeshes, "default", sheet.name);
  const std::string path = kMeshes + "/" + sheet.name;
  plot_group(file, path, "position", 3, 0);
  const auto coordinates = static_cast<std::size_t>(sheet.coordinates);
  file.array(path + "/position", sheet.position_m, {frames, sheet.vertex_count(), coordinates},
             "m");
  file.attribute(path + "/position", "sigma", sheet.sigma_m);
  file.attribute(path + "/position", "may_be_missing", std::int64_t{sheet.may_be_missing});
  file.array(path + "/material", flat(sheet.material_m), {sheet.vertex_count(), 2}, "m");
  if (!sheet.triangles.empty()) {
    std::vector<int> corners;
    corners.reserve(3 * sheet.triangles.size());
    for (const auto& triangle : sheet.triangles)
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    file.array(path + "/connectivity", corners, {sheet.triangles.size(), 3});
  }
  if (!sheet.outline_m.empty())
    file.array(path + "/outline", flat(sheet.outline_m), {sheet.outline_m.size(), 2}, "m");
  if (!sheet.vertex_name.empty()) file.array(path + "/vertex_name", sheet.vertex_name);
  if (!sheet.sigma_per_vertex_m.empty())
    file.array(path + "/vertex_sigma", sheet.sigma_per_vertex_m, "m");
}

void write_clip(H5Writer& file, const ClipTrack& clip, std::size_t order) {
  const std::string path = kClips + "/" + clip.id;
  plot_group(file, path, "position", 2, order);
  write_poses(file, path, clip.pose);
  file.text(path + "/role", clip.is_free ? "free" : "prescribed");
  if (!clip.region_m.empty())
    file.array(path + "/region", flat(clip.region_m), {clip.region_m.size(), 2}, "m");
  if (!clip.vertices.empty()) file.array(path + "/vertices", clip.vertices);
  file.number(path + "/mass", clip.mass_kg, "kg");
  file.array(path + "/centre_of_mass", flat(clip.centre_of_mass_m), "m");
  file.array(path + "/grip_position", flat(clip.grip.position_m), "m");
  file.array(path + "/grip_rotation", {clip.grip.rotation.begin(), clip.grip.rotation.end()}, "1");
}

void write_cord(H5Writer& file, const CordTrack& cord, std::size_t order) {
  const std::string path = kCords + "/" + cord.id;
  plot_group(file, path, "tension", 1, order);
  file.array(path + "/tension", cord.tension_N, "N");
  file.attribute(path + "/tension", "sigma", cord.sigma_N);
  file.attribute(path + "/tension", "may_be_missing", std::int64_t{cord.may_be_missing});
  file.array(path + "/direction", flat(cord.direction), {cord.direction.size(), 3}, "1");
  file.text(path + "/clip", cord.clip);
  file.array(path + "/attachment", flat(cord.attachment_m), "m");
}

void write_support(H5Writer& file, const SupportTrack& support, std::size_t order) {
  const std::string path = kSupports + "/" + support.id;
  plot_group(file, path, "edge", 1, order);
  file.array(path + "/edge", support.edge_m, "m");
  file.text(path + "/along", std::string(1, support.along));
  file.text(path + "/bears", support.bears_above ? "above" : "below");
  write_poses(file, path, support.pose);
}

}  // namespace

std::string default_group(const Sheet& sheet) {
  return sheet.cords.empty() ? "meshes" : "cords";
}

void write_sheet(H5Writer& file, const Sheet& sheet, std::size_t frames) {
  write_mesh(file, sheet, frames);
  file.group(kClips, "NXcollection");
  for (std::size_t i = 0; i < sheet.clips.size(); ++i) write_clip(file, sheet.clips[i], i);
  file.group(kCords, "NXcollection");
  if (!sheet.cords.empty()) file.attribute(kCords, "default", sheet.cords.front().id);
  for (std::size_t i = 0; i < sheet.cords.size(); ++i) write_cord(file, sheet.cords[i], i);
  file.group(kSupports, "NXcollection");
  for (std::size_t i = 0; i < sheet.supports.size(); ++i) write_support(file, sheet.supports[i], i);
  if (sheet.slack) {
    file.group(kSlack, "NXcollection");
    file.array(kSlack + "/clips", {sheet.slack->clips[0], sheet.slack->clips[1]});
    file.number(kSlack + "/closer_than", sheet.slack->closer_than_m, "m");
  }
  file.array(kGravity, flat(sheet.gravity_m_s2), "m/s^2");
}

}  // namespace tenter::capture
