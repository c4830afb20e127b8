// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet_import/sheet_tracks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/not_a_number.h"
#include "common/capture/csv/branch_detection.h"

namespace tenter::capture {

namespace {

/// The pose that undoes `pose`: with it as grip, material lies at (u, v, 0) when the clip is there.
RigidPose inverse(const RigidPose& pose) {
  const auto [w, x, y, z] = pose.rotation;
  const Vec3& p = pose.position_m;
  // rows of the transposed rotation
  const Vec3 rows[3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
  RigidPose back;
  back.rotation = {w, -x, -y, -z};
  for (std::size_t i = 0; i < 3; ++i)
    back.position_m[i] = -(rows[i][0] * p[0] + rows[i][1] * p[1] + rows[i][2] * p[2]);
  return back;
}

}  // namespace

Expected<void> SheetTracks::read(const std::unordered_map<std::string, int>& vertex_of) {
  Sheet& sheet = *capture_.sheet;
  for (const ClipSpec& spec : description_.clips) {
    ClipTrack clip = spec.track;
    for (const std::string& name : spec.vertices) {
      const auto vertex = vertex_of.find(name);
      if (vertex == vertex_of.end())
        return bad_input(folder_.json() + ": clip \"" + clip.id + "\" clamps \"" + name +
                         "\", which is no vertex.");
      clip.vertices.push_back(vertex->second);
    }
    auto read = poses(spec.pose);
    if (!read) return tl::unexpected(read.error());
    clip.pose = std::move(*read);
    if (spec.grip_from_first_frame) clip.grip = inverse(clip.pose.front());
    sheet.clips.push_back(std::move(clip));
  }
  for (const CordSpec& spec : description_.cords) {
    CordTrack cord = spec.track;
    if (auto ok = spec.over ? join_tension(spec, cord) : read_tension(spec, cord); !ok) return ok;
    sheet.cords.push_back(std::move(cord));
  }
  for (const SupportSpec& spec : description_.supports) {
    SupportTrack support = spec.track;
    if (auto ok = read_edge(spec, support); !ok) return ok;
    auto read = poses(spec.pose);
    if (!read) return tl::unexpected(read.error());
    support.pose = std::move(*read);
    sheet.supports.push_back(std::move(support));
  }
  return {};
}

Expected<void> SheetTracks::all_seen(const SheetTable& table, const std::string& what,
                                     const std::vector<bool>& seen) const {
  const auto gap = std::find(seen.begin(), seen.end(), false);
  if (gap == seen.end()) return {};
  const auto f = static_cast<std::size_t>(gap - seen.begin());
  return bad_input(table.name() + ": has no row for run " +
                   std::to_string(capture_.runs[static_cast<std::size_t>(capture_.run[f])].number) +
                   ", frame " + std::to_string(capture_.frame[f]) + ", where " + what +
                   " is needed.");
}

Expected<std::vector<RigidPose>> SheetTracks::poses(const PoseSpec& spec) {
  std::vector<RigidPose> poses(capture_.frame_count(), spec.constant);
  if (!spec.table) return poses;
  const Expected<SheetTable> table = SheetTable::make(folder_, *spec.table);
  if (!table) return tl::unexpected(table.error());
  std::vector<bool> seen(poses.size(), false);
  for (const std::size_t row : table->rows()) {
    const auto frame = table->frame(row, frames_);
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) continue;
    if (seen[**frame])
      return table->at(row, table->column("frame"), "this frame has been given before");
    seen[**frame] = true;
    RigidPose& pose = poses[**frame];
    const auto put = [&](const char* use, const UnitConversion& to_si,
                         double& out) -> Expected<void> {
      if (!table->has(use)) return {};
      const Expected<double> value = table->number(row, table->column(use), to_si);
      if (!value) return tl::unexpected(value.error());
      out = *value;
      return {};
    };
    for (std::size_t c = 0; c < 3; ++c)
      if (auto ok = put(std::string(1, "xyz"[c]).c_str(), spec.table->to_si, pose.position_m[c]);
          !ok)
        return tl::unexpected(ok.error());
    for (std::size_t c = 0; c < 4; ++c)
      if (auto ok = put((std::string("q") + "wxyz"[c]).c_str(), {}, pose.rotation[c]); !ok)
        return tl::unexpected(ok.error());
  }
  if (auto ok = all_seen(*table, "a pose for " + spec.table->key, seen); !ok)
    return tl::unexpected(ok.error());
  return poses;
}

Expected<void> SheetTracks::read_tension(const CordSpec& spec, CordTrack& cord) {
  cord.tension_N.assign(capture_.frame_count(), kNaN);
  cord.direction.assign(capture_.frame_count(), spec.direction);
  const Expected<SheetTable> table = SheetTable::make(folder_, spec.tension);
  if (!table) return tl::unexpected(table.error());
  std::vector<bool> seen(capture_.frame_count(), false);
  for (const std::size_t row : table->rows()) {
    const auto frame = table->frame(row, frames_);
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) continue;
    if (seen[**frame])
      return table->at(row, table->column("frame"), "this frame has been given before");
    seen[**frame] = true;
    const Expected<double> tension = table->number(row, table->column("tension"),
                                                   spec.tension.to_si, spec.tension.may_be_missing);
    if (!tension) return tl::unexpected(tension.error());
    cord.tension_N[**frame] = *tension;
    for (std::size_t c = 0; c < 3 && table->has("dx"); ++c) {
      const Expected<double> d = table->number(row, table->column(std::string("d") + "xyz"[c]), {});
      if (!d) return tl::unexpected(d.error());
      cord.direction[**frame][c] = *d;
    }
  }
  const bool needs_all = !spec.tension.may_be_missing || table->has("dx");
  return needs_all ? all_seen(*table, "a tension of cord \"" + cord.id + "\"", seen)
                   : Expected<void>();
}

/// A load cell with a clock of its own: its readings are over the way of a clip, and a frame takes
/// the value at the place where its picture shows the clip.
Expected<void> SheetTracks::join_tension(const CordSpec& spec, CordTrack& cord) {
  const CordSpec::Over& over = *spec.over;
  const ClipTrack* clip = capture_.sheet->find_clip(over.clip);
  if (!clip)
    return bad_input(folder_.json() + ": cord \"" + cord.id + "\" is over clip \"" + over.clip +
                     "\", which is not there.");
  const Expected<SheetTable> table = SheetTable::make(folder_, spec.tension);
  if (!table) return tl::unexpected(table.error());
  std::vector<std::pair<double, double>> curve;  // place, tension
  const std::size_t place = table->column("over");
  double sign = 0.0;
  for (const std::size_t row : table->rows()) {
    const Expected<double> at = table->number(row, place, over.to_m);
    if (!at) return tl::unexpected(at.error());
    const Expected<double> tension =
        table->number(row, table->column("tension"), spec.tension.to_si);
    if (!tension) return tl::unexpected(tension.error());
    if (!curve.empty()) {
      const double step = *at - curve.back().first;
      if (sign == 0.0) sign = step;
      if (!(step * sign > 0.0))
        return table->at(row, place, "does not go on in one direction, so frames cannot be joined");
    }
    curve.emplace_back(*at, *tension);
  }
  std::sort(curve.begin(), curve.end());
  cord.tension_N.assign(capture_.frame_count(), kNaN);
  cord.direction.assign(capture_.frame_count(), spec.direction);
  for (std::size_t f = 0; f < cord.tension_N.size(); ++f) {
    const double at = clip->pose[f].position_m[over.coordinate];
    if (at < curve.front().first || at > curve.back().first) {
      if (spec.tension.may_be_missing) continue;
      return bad_input(table->name() + ": has no tension where clip \"" + over.clip +
                       "\" is in frame " + std::to_string(capture_.frame[f]) + ", and " +
                       folder_.json() + " does not declare missing values.");
    }
    const auto next =
        std::max(curve.begin() + 1,
                 std::lower_bound(curve.begin(), curve.end(),
                                  std::pair(at, -std::numeric_limits<double>::infinity())));
    if (next == curve.end()) {  // a table of one row
      cord.tension_N[f] = curve.back().second;
      continue;
    }
    const auto& [x0, t0] = *(next - 1);
    const auto& [x1, t1] = *next;
    cord.tension_N[f] = t0 + (t1 - t0) * (at - x0) / (x1 - x0);
  }
  return {};
}

Expected<void> SheetTracks::read_edge(const SupportSpec& spec, SupportTrack& support) {
  support.edge_m.assign(capture_.frame_count(), spec.edge_m);
  if (!spec.edge) return {};
  const Expected<SheetTable> table = SheetTable::make(folder_, *spec.edge);
  if (!table) return tl::unexpected(table.error());
  std::vector<bool> seen(capture_.frame_count(), false);
  for (const std::size_t row : table->rows()) {
    const auto frame = table->frame(row, frames_);
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) continue;
    if (seen[**frame])
      return table->at(row, table->column("frame"), "this frame has been given before");
    seen[**frame] = true;
    const Expected<double> edge = table->number(row, table->column("edge"), spec.edge->to_si);
    if (!edge) return tl::unexpected(edge.error());
    support.edge_m[**frame] = *edge;
  }
  return all_seen(*table, "the edge of support \"" + support.id + "\"", seen);
}

void detect_branches_of_runs(Capture& capture) {
  capture.branch.clear();
  for (std::size_t begin = 0; begin < capture.frame_count();) {
    std::size_t end = begin + 1;
    while (end < capture.frame_count() && capture.run[end] == capture.run[begin]) ++end;
    std::vector<double> driving;
    for (const ClipTrack& clip : capture.sheet->clips) {
      std::vector<double> travel;
      for (std::size_t f = begin; f < end; ++f) {
        const Vec3& from = clip.pose[begin].position_m;
        const Vec3& to = clip.pose[f].position_m;
        travel.push_back(std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]));
      }
      if (driving.empty() || *std::max_element(travel.begin(), travel.end()) >
                                 *std::max_element(driving.begin(), driving.end()))
        driving = travel;
    }
    std::vector<double> time;
    if (!capture.time_s.empty())
      time.assign(capture.time_s.begin() + static_cast<std::ptrdiff_t>(begin),
                  capture.time_s.begin() + static_cast<std::ptrdiff_t>(end));
    const std::vector<Branch> branch = driving.empty()
                                           ? std::vector<Branch>(end - begin, Branch::other)
                                           : detect_branches(driving, time);
    capture.branch.insert(capture.branch.end(), branch.begin(), branch.end());
    begin = end;
  }
}

}  // namespace tenter::capture
