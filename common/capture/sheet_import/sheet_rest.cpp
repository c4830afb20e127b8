// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet_import/sheet_rest.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tenter::capture {

namespace {

constexpr double kNear = 0.05;  // of the distance asked for, that the nearest frame may be off

/// Inverse rotation of a place less the position.
Vec3 into(const RigidPose& pose, const Vec3& place) {
  const auto [w, x, y, z] = pose.rotation;
  const Vec3 d = {place[0] - pose.position_m[0], place[1] - pose.position_m[1],
                  place[2] - pose.position_m[2]};
  return {
      (1 - 2 * (y * y + z * z)) * d[0] + 2 * (x * y + w * z) * d[1] + 2 * (x * z - w * y) * d[2],
      2 * (x * y - w * z) * d[0] + (1 - 2 * (x * x + z * z)) * d[1] + 2 * (y * z + w * x) * d[2],
      2 * (x * z + w * y) * d[0] + 2 * (y * z - w * x) * d[1] + (1 - 2 * (x * x + y * y)) * d[2]};
}

/// Where the clip has in its material what is seen at a place in space.
Vec2 seen_by(const ClipTrack& clip, std::size_t frame, const Vec3& place) {
  const Vec3 at = into(clip.grip, into(clip.pose[frame], place));
  return {at[0], at[1]};
}

Vec2 middle(const ClipTrack& clip) {
  Vec2 sum{};
  for (const Vec2& corner : clip.region_m)
    for (std::size_t c = 0; c < 2; ++c)
      sum[c] += corner[c] / static_cast<double>(clip.region_m.size());
  return sum;
}

double dot(const Vec2& a, const Vec2& b) {
  return a[0] * b[0] + a[1] * b[1];
}

/// Of one run, by its index: the frame nearest to the distance.
std::optional<std::size_t> frame_at(const Capture& capture, const RestSpec& rest, int run) {
  std::optional<std::size_t> best;
  const auto off = [&](std::size_t f) {
    return std::abs(capture.sheet->distance_m(rest.clips, f) - rest.read_at_m);
  };
  for (std::size_t f = 0; f < capture.frame_count(); ++f)
    if (capture.run[f] == run && (!best || off(f) < off(*best))) best = f;
  if (best && off(*best) > kNear * rest.read_at_m) best.reset();
  return best;
}

Expected<std::vector<std::size_t>> frames_at(const Capture& capture, const RestSpec& rest) {
  std::vector<std::size_t> frames;
  std::vector<bool> is_found(rest.runs.size(), false);
  for (std::size_t run = 0; run < capture.runs.size(); ++run) {
    const int number = capture.runs[run].number;
    const auto asked = std::ranges::find(rest.runs, number);
    if (!rest.runs.empty() && asked == rest.runs.end()) continue;
    if (asked != rest.runs.end())
      is_found[static_cast<std::size_t>(asked - rest.runs.begin())] = true;
    const auto frame = frame_at(capture, rest, static_cast<int>(run));
    if (!frame)
      return bad_input("rest.read_at: in run " + std::to_string(number) + " clips \"" +
                       rest.clips[0] + "\" and \"" + rest.clips[1] +
                       "\" are never nearly so far apart");
    frames.push_back(*frame);
  }
  for (std::size_t i = 0; i < is_found.size(); ++i)
    if (!is_found[i])
      return bad_input("rest.runs: there is no run " + std::to_string(rest.runs[i]));
  return frames;
}

}  // namespace

RestSpec read_rest(JsonObject object) {
  RestSpec rest;
  const std::vector<std::string> clips = object.texts("clips");
  if (clips.size() == 2)
    rest.clips = {clips[0], clips[1]};
  else
    object.defect().note(object.path_of("clips"), "must name two clips");
  for (const auto& [key, value] :
       {std::pair{"slack_below", &rest.slack_below_m}, std::pair{"read_at", &rest.read_at_m}}) {
    const auto given = object.maybe_measure(key, "m");
    if (given && !(*given > 0.0))
      object.defect().note(object.path_of(key), "must be a length above zero");
    *value = given.value_or(0.0);
  }
  if (const nlohmann::json* runs = object.raw("runs")) {
    const bool is_list = runs->is_array() && !runs->empty() &&
                         std::ranges::all_of(*runs, [](const nlohmann::json& run) {
                           return run.is_number_integer();
                         });
    if (is_list)
      rest.runs = runs->get<std::vector<int>>();
    else
      object.defect().note(object.path_of("runs"), "must be a list of whole numbers");
  }
  object.finish();
  return rest;
}

Expected<std::vector<Vec2>> places_at_rest(const Capture& capture, const RestSpec& rest) {
  const Sheet& sheet = *capture.sheet;
  for (const std::string& id : rest.clips) {
    const ClipTrack* clip = sheet.find_clip(id);
    if (!clip) return bad_input("rest.clips: there is no clip \"" + id + "\"");
    if (clip->region_m.empty())
      return bad_input("rest.clips: clip \"" + id + "\" has no region, so its middle is not known");
  }
  const ClipTrack& a = *sheet.find_clip(rest.clips[0]);
  const ClipTrack& b = *sheet.find_clip(rest.clips[1]);
  const Vec2 from = middle(a), to = middle(b);
  const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
  if (!(length > 0.0)) return bad_input("rest.clips: they clamp the same material");
  const Vec2 along = {(to[0] - from[0]) / length, (to[1] - from[1]) / length};
  const Vec2 across = {-along[1], along[0]};
  const auto frames = frames_at(capture, rest);
  if (!frames) return tl::unexpected(frames.error());

  std::vector<Vec2> places(sheet.vertex_count(), Vec2{});
  for (const std::size_t f : *frames)
    for (std::size_t k = 0; k < places.size(); ++k) {
      Vec3 seen{};
      for (std::size_t c = 0; c < static_cast<std::size_t>(sheet.coordinates); ++c)
        seen[c] = sheet.position_m[sheet.at(f, k) + c];
      const Vec2 of_a = seen_by(a, f, seen), of_b = seen_by(b, f, seen);
      const double beyond_a = dot(of_a, along) - dot(from, along);
      const double before_b = dot(to, along) - dot(of_b, along);
      const double t = beyond_a / (beyond_a + before_b);
      const double wide = (1.0 - t) * dot(of_a, across) + t * dot(of_b, across);
      if (!std::isfinite(wide))
        return bad_input("rest.read_at: vertex " + std::to_string(k) + " is not seen in frame " +
                         std::to_string(capture.frame[f]) + ", which tells its place");
      const double deep = dot(from, along) + t * length;
      for (std::size_t c = 0; c < 2; ++c)
        places[k][c] += (deep * along[c] + wide * across[c]) / static_cast<double>(frames->size());
    }
  return places;
}

}  // namespace tenter::capture
