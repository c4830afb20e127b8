// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sheets/sheet_faults.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenter::twin {
namespace {

/// The bar lags by the play: it follows when the slack is used up.
void give_play(double play_m, bool along_u, Protocol& path) {
  const int axis = along_u ? 0 : 1;
  double follows_m = 0.0;
  for (ProtocolFrame& frame : path.frames) {
    double& way_m = frame.poses[1].position_m[axis];
    follows_m = std::clamp(follows_m, way_m - play_m, way_m + play_m);
    way_m = follows_m;
  }
}

/// With the knots of the path's turns, what a clock says at each of its frames.
std::vector<double> clock_of(const SheetPlan& plan) {
  std::vector<double> clock_s;
  for (const ProtocolFrame& frame : plan.path.frames)
    clock_s.push_back((clock_s.empty() ? 0.0 : clock_s.back()) + frame.duration_s);
  return clock_s;
}

double at_time(const std::vector<double>& clock_s, const std::vector<double>& values,
               double when_s) {
  const auto after = std::upper_bound(clock_s.begin(), clock_s.end(), when_s);
  if (after == clock_s.begin()) return values.front();
  if (after == clock_s.end()) return values.back();
  const auto k = static_cast<std::size_t>(after - clock_s.begin());
  const double share = (when_s - clock_s[k - 1]) / (clock_s[k] - clock_s[k - 1]);
  return (1.0 - share) * values[k - 1] + share * values[k];
}

/// Which way a cell of the plan reads at a frame of the path, on which clip.
struct Cell {
  std::size_t clip;
  Eigen::Vector3d way;
};
Cell cell_of(const SheetPlan& plan, std::size_t k, std::size_t frame) {
  const std::size_t each = plan.is_frame ? 2 : 1;
  const ProtocolClip& clip = plan.path.clips[k / each];
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(clip.pull);
  return {k / each,
          plan.path.frames[frame].poses[k / each].rotation * (k % each == 0 ? clip.pull : across)};
}

Eigen::Vector3d middle_of(const SheetPlan& plan, std::size_t clip, std::size_t frame) {
  const Region& grip = plan.path.clips[clip].grip;
  const ClipPose& pose = plan.path.frames[frame].poses[clip];
  return pose.rotation *
             Eigen::Vector3d(0.5 * (grip.lo_u + grip.hi_u), 0.5 * (grip.lo_v + grip.hi_v), 0.0) +
         pose.position_m;
}

/// +1 while the cell's clip is pulled its way, -1 while it is let back, as in the frame before
/// where it rests.
std::vector<double> motion_of(const SheetPlan& plan, std::size_t k) {
  std::vector<double> motion = {0.0};
  for (std::size_t f = 1; f < plan.path.frames.size(); ++f) {
    const Cell cell = cell_of(plan, k, f);
    const double moved =
        cell.way.dot(middle_of(plan, cell.clip, f) - middle_of(plan, cell.clip, f - 1));
    motion.push_back(moved > 1e-9 ? 1.0 : moved < -1e-9 ? -1.0 : motion.back());
  }
  return motion;
}

Eigen::VectorXd forces_at(const SheetPlan& plan, const SheetTwin& done, std::size_t seen,
                          const SheetFaults& faults) {
  const std::vector<double> clock_s = clock_of(plan);
  const auto f = static_cast<std::size_t>(plan.seen[seen]);
  Eigen::VectorXd shown(static_cast<Eigen::Index>(plan.cells.size()));
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    const bool is_own = plan.cells[k] == faults.cell;
    const std::vector<double> motion = motion_of(plan, k);
    std::vector<double> tension_N;
    for (std::size_t i = 0; i < clock_s.size(); ++i) {
      const Cell cell = cell_of(plan, k, i);
      tension_N.push_back(done.clip_force_N[i][cell.clip].dot(cell.way) *
                          (1.0 + (is_own ? faults.cord_friction * motion[i] : 0.0)));
    }
    const double beat_s = faults.alias_s * std::sin(2.0 * std::numbers::pi * faults.alias_turns *
                                                    static_cast<double>(seen));
    double force_N = at_time(clock_s, tension_N, clock_s[f] - faults.delay_s - beat_s);
    if (is_own)
      force_N = std::min(faults.cap_N,
                         faults.gain * force_N + faults.offset_N + faults.drift_N_s * clock_s[f]);
    shown[static_cast<Eigen::Index>(k)] = force_N;
  }
  return shown;
}

/// Full beside what is hidden, none from one and eight tenths of the spacing on.
double beside(const SheetSuite& suite, const std::vector<bool>& hidden, std::size_t place) {
  constexpr double kFull = 1.2, kNone = 1.8;  // of the spacing
  double nearest_m = 1e300;
  for (std::size_t k = 0; k < hidden.size(); ++k)
    if (hidden[k])
      nearest_m = std::min(nearest_m, (suite.places_m[k] - suite.places_m[place]).norm());
  return std::clamp((kNone - nearest_m / suite.spacing_m) / (kNone - kFull), 0.0, 1.0);
}

}  // namespace

Hidden3 hidden_places(const SheetSuite& suite, Random choices) {
  constexpr double kLost = 0.015, kFramesWithObstacle = 0.35, kReach = 1.5;
  Hidden3 hidden;
  const double side_m = suite.plans.front().path.side_m;
  for (const SheetPlan& plan : suite.plans) {
    auto& frames = hidden.emplace_back();
    for (std::size_t f = 0; f < plan.seen.size(); ++f) {
      auto& places = frames.emplace_back();
      const bool is_blocked = suite.traits.has_obstacle && choices.uniform() < kFramesWithObstacle;
      const Eigen::Vector2d at(side_m * choices.uniform(0.2, 0.8),
                               side_m * choices.uniform(0.2, 0.8));
      for (const Eigen::Vector2d& place : suite.places_m)
        places.push_back(choices.uniform() < kLost ||
                         (is_blocked && (place - at).norm() < kReach * suite.spacing_m));
    }
  }
  return hidden;
}

std::vector<Eigen::Vector2d> all_places(const SheetSuite& suite, double side_m) {
  std::vector<Eigen::Vector2d> places = suite.places_m;
  for (int j = 0; j <= suite.grid_cells; ++j)
    for (int i = 0; i <= suite.grid_cells; ++i)
      places.emplace_back(side_m * i / suite.grid_cells, side_m * j / suite.grid_cells);
  return places;
}

Expected<SheetDone> perform(const SheetSuite& suite, const Fabric& fabric,
                            const SheetFaults& faults, std::size_t plans) {
  Fabric weighed = fabric;
  weighed.mass_kg *= faults.mass_factor;
  const std::vector<Eigen::Vector2d> places = all_places(suite, fabric.side_m);
  SheetDone done;
  for (std::size_t p = 0; p < std::min(plans, suite.plans.size()); ++p) {
    const SheetPlan& plan = suite.plans[p];
    Protocol path = plan.path;
    if (faults.slip_plan == static_cast<int>(p))
      for (std::size_t f = static_cast<std::size_t>(faults.slip_frame); f < path.frames.size(); ++f)
        path.frames[f].poses[1].position_m -= faults.slip_m * path.clips[1].pull;
    if (faults.play_m > 0.0) give_play(faults.play_m, plan.along_u, path);
    done.plans.push_back(run_protocol(weighed, path, places, {.span_m = suite.span_m, .seed = 3}));
    if (!done.plans.back().failure.empty()) return bad_input(done.plans.back().failure);
  }
  return done;
}

SheetReadings read(const SheetSuite& suite, const SheetDone& done, const Hidden3& hidden,
                   const SheetFaults& faults) {
  SheetReadings readings;
  const auto count = static_cast<Eigen::Index>(suite.places_m.size());
  for (std::size_t p = 0; p < done.plans.size(); ++p) {
    const SheetPlan& plan = suite.plans[p];
    const bool is_posed = faults.posed_plan == static_cast<int>(p);
    const double angle = faults.turn_rad.norm();
    const Eigen::Matrix3d turn =
        is_posed && angle > 0.0
            ? Eigen::AngleAxisd(angle, faults.turn_rad / angle).toRotationMatrix()
            : Eigen::Matrix3d::Identity();
    const Eigen::Vector3d middle(0.5 * plan.path.side_m, 0.5 * plan.path.side_m, 0.0);
    auto& frames = readings.plans.emplace_back();
    for (std::size_t s = 0; s < plan.seen.size(); ++s) {
      SheetReadings::Frame& frame = frames.emplace_back();
      frame.points_m =
          done.plans[p].positions_m[static_cast<std::size_t>(plan.seen[s])].leftCols(count);
      for (Eigen::Index k = 0; k < count; ++k) {
        Eigen::Vector3d x = frame.points_m.col(k);
        if (faults.occlusion_m != 0.0)
          x.z() += faults.occlusion_m * beside(suite, hidden[p][s], static_cast<std::size_t>(k));
        if (is_posed) x = middle + turn * (x - middle) + faults.shift_m;
        frame.points_m.col(k) = middle + faults.scale * (x - middle);
      }
      frame.forces_N = forces_at(plan, done.plans[p], s, faults);
    }
  }
  for (const SheetFaults::Misread& m : faults.misread)
    if (static_cast<std::size_t>(m.plan) < readings.plans.size())
      readings.plans[static_cast<std::size_t>(m.plan)][static_cast<std::size_t>(m.seen)]
          .points_m.col(m.place) += m.jump_m;
  return readings;
}

}  // namespace tenter::twin
