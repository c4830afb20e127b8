// SPDX-License-Identifier: Apache-2.0
#include "tests/common/capture/sheet/support.h"

#include <cmath>
#include <random>

#include "common/base/not_a_number.h"

namespace tenter::capture::test {

namespace {

Capture empty_capture(int frames) {
  Capture c;
  c.kind = "deforming_sheet";
  c.title = "A sheet";
  c.specimen.name = "S1";
  c.specimen.material = "cloth";
  c.specimen.area_density_kg_m2 = 0.15;
  c.protocol.name = "pull";
  c.protocol.phases = {{"pull", "ramp", std::nullopt}};
  c.provenance.synthetic = true;
  c.provenance.source = "a test";
  c.runs = {{1, ""}};
  for (int f = 0; f < frames; ++f) c.frame.push_back(f + 1);
  const auto n = static_cast<std::size_t>(frames);
  c.run.assign(n, 0);
  c.phase.assign(n, 0);
  c.branch.assign(n, Branch::load);
  c.sheet.emplace();
  return c;
}

void add_grid(Sheet& sheet, int side, double spacing_m) {
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) sheet.material_m.push_back({i * spacing_m, j * spacing_m});
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i;
      sheet.triangles.push_back({a, a + 1, a + side + 1});
      sheet.triangles.push_back({a, a + side + 1, a + side});
    }
}

}  // namespace

Capture small_sheet_capture() {
  Capture c = empty_capture(4);
  c.runs = {{2, "g"}, {5, "g"}};
  c.run = {0, 0, 1, 1};
  c.frame = {1, 2, 1, 7};
  c.branch = {Branch::load, Branch::unload, Branch::load, Branch::other};
  c.time_s = {0.0, 0.5, 0.0, 1.0 / 3.0};
  Sheet& sheet = *c.sheet;
  sheet.name = "front";
  add_grid(sheet, 3, 0.05);
  for (std::size_t f = 0; f < 4; ++f)
    for (const Vec2& place : sheet.material_m) {
      const double stretch = 1.0 + 0.01 * static_cast<double>(f) / 3.0;
      sheet.position_m.insert(sheet.position_m.end(), {stretch * place[0], place[1], 0.1 + 0.2});
    }
  sheet.may_be_missing = true;
  for (std::size_t c3 = 0; c3 < 3; ++c3) sheet.position_m[sheet.at(2, 4) + c3] = kNaN;
  sheet.outline_m = {{0.0, 0.0}, {0.1, 0.0}, {0.12, 0.1}, {0.0, 0.1}};
  sheet.sigma_m = 7.5e-5;
  sheet.sigma_per_vertex_m.assign(9, 7.5e-5);
  sheet.sigma_per_vertex_m[8] = 2e-4;

  ClipTrack fixed;
  fixed.id = "fixed";
  fixed.region_m = {{0.0, 0.0}, {0.01, 0.0}, {0.01, 0.1}, {0.0, 0.1}};
  fixed.pose.resize(4);
  ClipTrack moved;
  moved.id = "moved";
  moved.vertices = {2, 5, 8};
  moved.is_free = true;
  moved.mass_kg = 0.012;
  moved.centre_of_mass_m = {0.1, 0.05, -0.002};
  moved.grip.position_m = {0.0, 0.0, 0.001};
  for (int f = 0; f < 4; ++f)
    moved.pose.push_back({{0.001 * f, 0.0, 0.3}, {std::cos(0.01 * f), 0.0, std::sin(0.01 * f), 0}});
  sheet.clips = {fixed, moved};

  CordTrack pull;
  pull.id = "pull";
  pull.clip = "moved";
  pull.attachment_m = {0.1, 0.02, 0.0};
  pull.sigma_N = 0.003;
  pull.may_be_missing = true;
  pull.tension_N = {0.1, 0.2 + 0.1, kNaN, 0.4};
  pull.direction.assign(4, {1.0, 0.0, 0.0});
  pull.direction[3] = {0.6, 0.0, 0.8};
  CordTrack hang = pull;
  hang.id = "hang";
  hang.may_be_missing = false;
  hang.tension_N = {1.0, 1.0, 1.0, 1.0};
  hang.direction.assign(4, {0.0, 0.0, 1.0});
  sheet.cords = {pull, hang};

  SupportTrack table;
  table.id = "table";
  table.along = 'v';
  table.bears_above = false;
  table.edge_m = {0.0, 0.01, 0.02, 0.03};
  table.pose.resize(4);
  sheet.supports = {table};
  sheet.slack = SlackRule{{"fixed", "moved"}, 0.300005};
  sheet.gravity_m_s2 = {0.0, -9.81, 0.0};
  return c;
}

Capture rippled_sheet_capture(int side, int frames) {
  Capture c = empty_capture(frames);
  Sheet& sheet = *c.sheet;
  const double length = 0.1;
  add_grid(sheet, side, length / (side - 1));
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 7.5e-5);
  sheet.position_m.reserve(static_cast<std::size_t>(frames) * 3 * sheet.vertex_count());
  for (int f = 0; f < frames; ++f)
    for (const Vec2& place : sheet.material_m) {
      const double share = (f + 1.0) / frames;
      for (const double x :
           {place[0] * (1.0 + 0.05 * share), place[1], 0.002 * share * std::sin(60.0 * place[1])})
        sheet.position_m.push_back(x + noise(random));
    }
  sheet.sigma_m = 7.5e-5;
  for (const bool last : {false, true}) {
    ClipTrack clip;
    clip.id = last ? "moved" : "fixed";
    const double u = last ? length : 0.0;
    clip.region_m = {{u, 0.0}, {u, length}};
    clip.pose.resize(static_cast<std::size_t>(frames));
    if (last)
      for (int f = 0; f < frames; ++f)
        clip.pose[static_cast<std::size_t>(f)].position_m[0] = 0.05 * length * (f + 1.0) / frames;
    sheet.clips.push_back(clip);
  }
  CordTrack cord;
  cord.id = "pull";
  cord.clip = "moved";
  cord.sigma_N = 0.003;
  cord.direction.assign(static_cast<std::size_t>(frames), {1.0, 0.0, 0.0});
  for (int f = 0; f < frames; ++f) cord.tension_N.push_back(2.0 * (f + 1.0) / frames);
  sheet.cords = {cord};
  return c;
}

}  // namespace tenter::capture::test
