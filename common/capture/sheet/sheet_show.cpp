// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet/sheet_show.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/capture/show_words.h"

namespace tenter::capture {

namespace {

using nlohmann::ordered_json;

/// Vertices of all frames that lack a coordinate.
std::size_t unseen(const Sheet& sheet) {
  const auto coordinates = static_cast<std::size_t>(sheet.coordinates);
  std::size_t count = 0;
  for (std::size_t i = 0; i < sheet.position_m.size(); i += coordinates)
    count += static_cast<std::size_t>(
        std::any_of(sheet.position_m.begin() + static_cast<std::ptrdiff_t>(i),
                    sheet.position_m.begin() + static_cast<std::ptrdiff_t>(i + coordinates),
                    [](double v) { return std::isnan(v); }));
  return count;
}

struct Extents {
  Vec2 lo = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vec2 hi = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

Extents extents(const Sheet& sheet) {
  Extents e;
  for (const Vec2& place : sheet.material_m)
    for (std::size_t c = 0; c < 2; ++c) {
      e.lo[c] = std::min(e.lo[c], place[c]);
      e.hi[c] = std::max(e.hi[c], place[c]);
    }
  return e;
}

struct Tension {
  double lowest = std::numeric_limits<double>::quiet_NaN();
  double highest = std::numeric_limits<double>::quiet_NaN();
  std::size_t missing = 0;
};

Tension tension(const CordTrack& cord) {
  Tension t;
  for (const double value : cord.tension_N) {
    t.missing += static_cast<std::size_t>(std::isnan(value));
    t.lowest = std::fmin(t.lowest, value);
    t.highest = std::fmax(t.highest, value);
  }
  return t;
}

/// How far a clip gets from where it is in the first frame.
double travel_m(const ClipTrack& clip) {
  double furthest = 0.0;
  for (const RigidPose& pose : clip.pose) {
    double squared = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      squared += std::pow(pose.position_m[c] - clip.pose.front().position_m[c], 2);
    furthest = std::max(furthest, std::sqrt(squared));
  }
  return furthest;
}

std::string held_material(const ClipTrack& clip) {
  return clip.region_m.empty() ? std::to_string(clip.vertices.size()) + " vertices"
                               : "a region of " + std::to_string(clip.region_m.size()) + " corners";
}

/// Frames that the sheet's rule calls slack.
std::size_t slack_frames(const Sheet& sheet) {
  std::size_t count = 0;
  for (std::size_t f = 0; sheet.slack && f < sheet.find_clip(sheet.slack->clips[0])->pose.size();
       ++f)
    count += static_cast<std::size_t>(sheet.is_slack(f));
  return count;
}

std::string mm(double metres) {
  return number(metres * 1e3);
}

}  // namespace

std::string sheet_text(const Sheet& sheet) {
  const Extents e = extents(sheet);
  std::string out = padded("mesh", 12) + sheet.name + ": " + std::to_string(sheet.vertex_count()) +
                    (sheet.triangles.empty()
                         ? " points without triangles"
                         : " vertices, " + std::to_string(sheet.triangles.size()) + " triangles") +
                    ", u " + mm(e.lo[0]) + " .. " + mm(e.hi[0]) + " mm, v " + mm(e.lo[1]) + " .. " +
                    mm(e.hi[1]) + " mm\n";
  out += padded("positions", 12) + std::to_string(sheet.coordinates) + " coordinates, ";
  if (!sheet.sigma_per_vertex_m.empty())
    out += "sigma per vertex";
  else
    out += sheet.sigma_m > 0.0 ? "sigma " + mm(sheet.sigma_m) + " mm" : "sigma not known";
  if (const std::size_t missing = unseen(sheet); missing > 0)
    out += ", " + std::to_string(missing) + " not seen";
  out += "\n";
  if (!sheet.outline_m.empty())
    out += padded("outline", 12) + std::to_string(sheet.outline_m.size()) + " corners\n";
  for (const ClipTrack& clip : sheet.clips)
    out += padded("clip", 12) + clip.id + ": " + (clip.is_free ? "free" : "prescribed") +
           ", clamps " + held_material(clip) + ", mass " + number(clip.mass_kg * 1e3) +
           " g, travels " + mm(travel_m(clip)) + " mm\n";
  for (const CordTrack& cord : sheet.cords) {
    const Tension t = tension(cord);
    out += padded("cord", 12) + cord.id + " at " + cord.clip + ": " + number(t.lowest) + " .. " +
           number(t.highest) + " N" +
           (cord.sigma_N > 0.0 ? ", sigma " + number(cord.sigma_N) + " N" : ", sigma not known") +
           (t.missing > 0 ? ", missing " + std::to_string(t.missing) : "") + "\n";
  }
  for (const SupportTrack& support : sheet.supports) {
    const auto [low, high] = std::minmax_element(support.edge_m.begin(), support.edge_m.end());
    out += padded("support", 12) + support.id + ": bears the material " +
           (support.bears_above ? "above " : "below ") + support.along + " = " + mm(*low) + " .. " +
           mm(*high) + " mm\n";
  }
  if (sheet.slack)
    out += padded("slack", 12) + "where " + sheet.slack->clips[0] + " and " +
           sheet.slack->clips[1] + " are closer than " + mm(sheet.slack->closer_than_m) +
           " mm: " + std::to_string(slack_frames(sheet)) + " frames\n";
  out += padded("gravity", 12) + number(sheet.gravity_m_s2[0]) + ", " +
         number(sheet.gravity_m_s2[1]) + ", " + number(sheet.gravity_m_s2[2]) + " m/s2\n";
  return out;
}

ordered_json sheet_json(const Sheet& sheet) {
  const Extents e = extents(sheet);
  ordered_json out;
  out["mesh"] = {{"name", sheet.name},
                 {"vertices", sheet.vertex_count()},
                 {"triangles", sheet.triangles.size()},
                 {"coordinates", sheet.coordinates},
                 {"outline_corners", sheet.outline_m.size()},
                 {"u_m", {e.lo[0], e.hi[0]}},
                 {"v_m", {e.lo[1], e.hi[1]}},
                 {"sigma_m", sheet.sigma_m},
                 {"sigma_per_vertex", !sheet.sigma_per_vertex_m.empty()},
                 {"not_seen", unseen(sheet)}};
  out["clips"] = ordered_json::array();
  for (const ClipTrack& clip : sheet.clips)
    out["clips"].push_back({{"id", clip.id},
                            {"role", clip.is_free ? "free" : "prescribed"},
                            {"region_corners", clip.region_m.size()},
                            {"vertices", clip.vertices.size()},
                            {"mass_kg", clip.mass_kg},
                            {"travel_m", travel_m(clip)}});
  out["cords"] = ordered_json::array();
  for (const CordTrack& cord : sheet.cords) {
    const Tension t = tension(cord);
    out["cords"].push_back({{"id", cord.id},
                            {"clip", cord.clip},
                            {"lowest_N", t.lowest},
                            {"highest_N", t.highest},
                            {"missing", t.missing},
                            {"sigma_N", cord.sigma_N}});
  }
  out["supports"] = ordered_json::array();
  for (const SupportTrack& support : sheet.supports) {
    const auto [low, high] = std::minmax_element(support.edge_m.begin(), support.edge_m.end());
    out["supports"].push_back({{"id", support.id},
                               {"along", std::string(1, support.along)},
                               {"bears", support.bears_above ? "above" : "below"},
                               {"edge_m", {*low, *high}}});
  }
  if (sheet.slack)
    out["slack"] = {{"clips", sheet.slack->clips},
                    {"closer_than_m", sheet.slack->closer_than_m},
                    {"frames", slack_frames(sheet)}};
  out["gravity_m_s2"] = sheet.gravity_m_s2;
  return out;
}

}  // namespace tenter::capture
