// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet/sheet_validate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/capture/text_checks.h"

namespace tenter::capture {

namespace {

constexpr std::size_t kMostBodies = 1000;  // clips, cords or supports
constexpr std::size_t kMostVertices = 4000000;
constexpr double kUnitTolerance = 1e-6;  // of directions and quaternions

template <std::size_t N>
bool is_finite(const std::array<double, N>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

template <std::size_t N>
bool is_unit(const std::array<double, N>& values) {
  double squared = 0.0;
  for (const double v : values) squared += v * v;
  return std::abs(std::sqrt(squared) - 1.0) < kUnitTolerance;
}

bool is_not_negative(double value) {
  return value >= 0.0 && std::isfinite(value);
}

std::string number_of(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what;
}

Expected<void> check_vertices(const Sheet& sheet) {
  if (!well_formed(sheet.name))
    return bad_input("mesh " + quoted(sheet.name) + ": a name has only letters, digits and \"_\"");
  const std::size_t n = sheet.vertex_count();
  if (n == 0) return bad_input("the mesh has no vertices");
  if (n > kMostVertices) return bad_input("the mesh has too many vertices");
  for (std::size_t k = 0; k < n; ++k)
    if (!is_finite(sheet.material_m[k]))
      return bad_input("vertex " + std::to_string(k) + " has no place in the material");
  if (sheet.outline_m.size() == 1 || sheet.outline_m.size() == 2)
    return bad_input("the outline of the sheet needs three corners at least");
  for (const Vec2& corner : sheet.outline_m)
    if (!is_finite(corner)) return bad_input("the outline has a corner that is no place");
  if (!sheet.vertex_name.empty() && sheet.vertex_name.size() != n)
    return bad_input("the mesh has " + number_of(sheet.vertex_name.size(), "names for ") +
                     number_of(n, "vertices"));
  std::set<std::string> names;
  for (const std::string& name : sheet.vertex_name) {
    if (!well_formed(name))
      return bad_input("vertex " + quoted(name) + ": a name has only letters, digits and \"_\"");
    if (!names.insert(name).second) return bad_input("vertex " + quoted(name) + " appears twice");
  }
  return {};
}

Expected<void> check_triangles(const Sheet& sheet) {
  const auto n = static_cast<int>(sheet.vertex_count());
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& corners = sheet.triangles[t];
    const std::string name = "triangle " + std::to_string(t);
    for (const int corner : corners)
      if (corner < 0 || corner >= n)
        return bad_input(name + " names vertex " + std::to_string(corner) + " of " +
                         std::to_string(n));
    const auto place = [&](std::size_t c) {
      return sheet.material_m[static_cast<std::size_t>(corners[c])];
    };
    const Vec2 a = place(0), b = place(1), c = place(2);
    const double twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!(twice_area > 0.0))
      return bad_input(name + " has no area, or runs clockwise in the material");
  }
  return {};
}

Expected<void> check_positions(const Capture& capture, const Sheet& sheet) {
  if (sheet.coordinates != 2 && sheet.coordinates != 3)
    return bad_input("positions have 2 or 3 coordinates, not " + std::to_string(sheet.coordinates));
  const auto coordinates = static_cast<std::size_t>(sheet.coordinates);
  const std::size_t per_frame = sheet.vertex_count() * coordinates;
  if (sheet.position_m.size() != capture.frame_count() * per_frame)
    return bad_input("there are " + number_of(sheet.position_m.size(), "coordinates for ") +
                     number_of(capture.frame_count(), "frames of ") +
                     number_of(per_frame, "coordinates"));
  if (!is_not_negative(sheet.sigma_m))
    return bad_input("the positions have a negative or unusable sigma");
  if (!sheet.sigma_per_vertex_m.empty() && sheet.sigma_per_vertex_m.size() != sheet.vertex_count())
    return bad_input("there are " + number_of(sheet.sigma_per_vertex_m.size(), "sigmas for ") +
                     number_of(sheet.vertex_count(), "vertices"));
  for (std::size_t k = 0; k < sheet.sigma_per_vertex_m.size(); ++k)
    if (!is_not_negative(sheet.sigma_per_vertex_m[k]))
      return bad_input("vertex " + std::to_string(k) + " has a negative or unusable sigma");
  for (std::size_t i = 0; i < sheet.position_m.size(); ++i) {
    const double value = sheet.position_m[i];
    if (std::isfinite(value) || (std::isnan(value) && sheet.may_be_missing)) continue;
    const std::string vertex = "vertex " + std::to_string(i % per_frame / coordinates);
    return bad_input(vertex + (std::isnan(value) ? " has no position at " : " is infinite at ") +
                     at_frame(capture, i / per_frame) +
                     (std::isnan(value) ? " and missing positions are not declared" : ""));
  }
  return {};
}

Expected<void> check_poses(const Capture& capture, const std::string& name,
                           const std::vector<RigidPose>& poses) {
  if (poses.size() != capture.frame_count())
    return bad_input(name + " has " + number_of(poses.size(), "poses for ") +
                     number_of(capture.frame_count(), "frames"));
  for (std::size_t f = 0; f < poses.size(); ++f) {
    if (!is_finite(poses[f].position_m))
      return bad_input(name + " has no position at " + at_frame(capture, f));
    if (!is_unit(poses[f].rotation))
      return bad_input(name + " has a rotation that is no unit quaternion at " +
                       at_frame(capture, f));
  }
  return {};
}

Expected<void> check_grip(const Sheet& sheet, const ClipTrack& clip, const std::string& name) {
  if (clip.region_m.empty() == clip.vertices.empty())
    return bad_input(name + " must clamp either a region of the material or vertices");
  if (clip.region_m.size() == 1) return bad_input(name + " clamps a region of one corner");
  for (const Vec2& corner : clip.region_m)
    if (!is_finite(corner)) return bad_input(name + " has a corner that is no place");
  std::set<int> seen;
  for (const int vertex : clip.vertices) {
    if (vertex < 0 || vertex >= static_cast<int>(sheet.vertex_count()))
      return bad_input(name + " clamps vertex " + std::to_string(vertex) + " of " +
                       std::to_string(sheet.vertex_count()));
    if (!seen.insert(vertex).second)
      return bad_input(name + " clamps vertex " + std::to_string(vertex) + " twice");
  }
  if (!clip.vertices.empty() && sheet.triangles.empty())
    return bad_input(name + " clamps vertices, but without triangles it has to name a region");
  if (!is_finite(clip.grip.position_m) || !is_unit(clip.grip.rotation))
    return bad_input(name + " has an unusable grip");
  return {};
}

/// Names of one kind of body: well formed, once each, not too many.
template <class Body>
Expected<void> check_ids(const std::vector<Body>& bodies, const std::string& kind) {
  if (bodies.size() > kMostBodies) return bad_input("there are too many of: " + kind);
  std::set<std::string> ids;
  for (const Body& body : bodies) {
    const std::string name = kind + " " + quoted(body.id);
    if (!well_formed(body.id))
      return bad_input(name + ": a name has only letters, digits and \"_\"");
    if (!ids.insert(body.id).second) return bad_input(name + " appears twice");
  }
  return {};
}

Expected<void> check_clips(const Capture& capture, const Sheet& sheet) {
  if (auto ok = check_ids(sheet.clips, "clip"); !ok) return ok;
  for (const ClipTrack& clip : sheet.clips) {
    const std::string name = "clip " + quoted(clip.id);
    if (auto ok = check_grip(sheet, clip, name); !ok) return ok;
    if (!is_not_negative(clip.mass_kg)) return bad_input(name + " has a negative or unusable mass");
    if (!is_finite(clip.centre_of_mass_m))
      return bad_input(name + " has an unusable centre of mass");
    if (auto ok = check_poses(capture, name, clip.pose); !ok) return ok;
  }
  return {};
}

Expected<void> check_cords(const Capture& capture, const Sheet& sheet) {
  if (auto ok = check_ids(sheet.cords, "cord"); !ok) return ok;
  for (const CordTrack& cord : sheet.cords) {
    const std::string name = "cord " + quoted(cord.id);
    if (!sheet.find_clip(cord.clip))
      return bad_input(name + " names clip " + quoted(cord.clip) + ", which is not there");
    if (!is_finite(cord.attachment_m)) return bad_input(name + " has an unusable attachment");
    if (!is_not_negative(cord.sigma_N))
      return bad_input(name + " has a negative or unusable sigma");
    if (cord.tension_N.size() != capture.frame_count() ||
        cord.direction.size() != capture.frame_count())
      return bad_input(name + " does not have one tension and direction for each of " +
                       number_of(capture.frame_count(), "frames"));
    for (std::size_t f = 0; f < cord.tension_N.size(); ++f) {
      const double tension = cord.tension_N[f];
      if (!std::isfinite(tension) && !(std::isnan(tension) && cord.may_be_missing))
        return bad_input(name + " has no tension at " + at_frame(capture, f) +
                         (cord.may_be_missing ? "" : " and does not declare missing values"));
      if (!is_unit(cord.direction[f]))
        return bad_input(name + " has a direction that is not of length one at " +
                         at_frame(capture, f));
    }
  }
  return {};
}

Expected<void> check_supports(const Capture& capture, const Sheet& sheet) {
  if (auto ok = check_ids(sheet.supports, "support"); !ok) return ok;
  for (const SupportTrack& support : sheet.supports) {
    const std::string name = "support " + quoted(support.id);
    if (support.along != 'u' && support.along != 'v')
      return bad_input(name + " must have its edge along u or v");
    if (support.edge_m.size() != capture.frame_count())
      return bad_input(name + " has " + number_of(support.edge_m.size(), "edges for ") +
                       number_of(capture.frame_count(), "frames"));
    for (std::size_t f = 0; f < support.edge_m.size(); ++f)
      if (!std::isfinite(support.edge_m[f]))
        return bad_input(name + " has no edge at " + at_frame(capture, f));
    if (auto ok = check_poses(capture, name, support.pose); !ok) return ok;
  }
  return {};
}

Expected<void> check_slack(const Sheet& sheet) {
  if (!sheet.slack) return {};
  const auto& [clips, closer_than_m] = *sheet.slack;
  for (const std::string& id : clips)
    if (!sheet.find_clip(id))
      return bad_input("slack frames are told by clip " + quoted(id) + ", which is not there");
  if (clips[0] == clips[1])
    return bad_input("slack frames are told by clip " + quoted(clips[0]) + " and itself");
  if (!(closer_than_m > 0.0) || !std::isfinite(closer_than_m))
    return bad_input("slack frames are told by a distance that is not above zero");
  return {};
}

}  // namespace

Expected<void> validate_sheet(const Capture& capture) {
  const Sheet& sheet = *capture.sheet;
  if (auto ok = check_vertices(sheet); !ok) return ok;
  if (auto ok = check_triangles(sheet); !ok) return ok;
  if (auto ok = check_positions(capture, sheet); !ok) return ok;
  if (auto ok = check_clips(capture, sheet); !ok) return ok;
  if (auto ok = check_cords(capture, sheet); !ok) return ok;
  if (auto ok = check_supports(capture, sheet); !ok) return ok;
  if (auto ok = check_slack(sheet); !ok) return ok;
  if (!is_finite(sheet.gravity_m_s2)) return bad_input("gravity is not a number");
  return {};
}

}  // namespace tenter::capture
