// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sheet/sheet_twin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/twin/fabrics/sheet/sheet_equilibrium.h"
#include "tests/twin/random.h"

namespace tenter::twin {

namespace {

/// Where something that holds the sheet ends, and how often the knot there counts.
using Ends = std::map<double, int>;

/// Irregular single knots between the ends.
std::vector<double> knots_between(const Ends& ends, double side_m, double span_m, Random& random) {
  constexpr double kSame = 1e-9, kIrregular = 0.25;
  std::vector<double> knots = {0.0};
  const auto fill_to = [&](double end) {
    const double from = knots.back(), width = end - from;
    const int spans = std::max(1, static_cast<int>(std::ceil(width / span_m - kSame)));
    for (int k = 1; k < spans; ++k)
      knots.push_back(from + width * (k + random.uniform(-kIrregular, kIrregular)) / spans);
    knots.push_back(end);
  };
  for (const auto& [end, count] : ends)
    if (end > kSame && end < side_m - kSame && end - knots.back() > kSame) fill_to(end);
  fill_to(side_m);
  return knots;
}

/// The knots with those at ends as often as the ends ask, less `fewer`.
SplineLine line_over(const std::vector<double>& knots, const Ends& ends, int fewer) {
  std::vector<double> all;
  for (const double knot : knots) {
    const auto found = ends.find(knot);
    const bool is_inside = knot > knots.front() && knot < knots.back();
    all.insert(all.end(), found != ends.end() && is_inside ? std::max(2, found->second - fewer) : 1,
               knot);
  }
  return SplineLine(all);
}

// A clip's end is triple in the plane, where the stretch jumps; the table's is double: what hangs
// over it stretches next to nothing.
Sheet sheet_for(const Fabric& fabric, const Protocol& protocol, const SheetTwinOptions& options) {
  Ends u, v;
  const auto add = [&](const Region& region, int count) {
    for (const double end : {region.lo_u, region.hi_u}) u[end] = count;
    for (const double end : {region.lo_v, region.hi_v}) v[end] = count;
  };
  for (const ProtocolClip& clip : protocol.clips) add(clip.grip, 3);
  for (const ProtocolFrame& frame : protocol.frames)
    if (frame.table) add(*frame.table, 2);
  Random random(stream_seed(options.seed, "knots"));
  const auto knots_u = knots_between(u, fabric.side_m, options.span_m, random);
  const auto knots_v = knots_between(v, fabric.side_m, options.span_m, random);
  return {fabric,
          {line_over(knots_u, u, 0), line_over(knots_v, v, 0), line_over(knots_u, u, 1),
           line_over(knots_v, v, 1)}};
}

/// Poses a share of the way from one frame to the next.
ClipPose between(const ClipPose& from, const ClipPose& to, double share) {
  const Eigen::Quaterniond a(from.rotation), b(to.rotation);
  return {a.slerp(share, b).toRotationMatrix(),
          (1.0 - share) * from.position_m + share * to.position_m};
}

/// The sheet and what is done to it.
class Rig {
 public:
  Rig(const Fabric& fabric, const Protocol& protocol, const SheetTwinOptions& options)
      : protocol_(protocol),
        sheet_(sheet_for(fabric, protocol, options)),
        x_(sheet_.flat()),
        poses_(protocol.clips.size()) {
    tolerance_.net_force_N = options.net_force_N;
    for (const ProtocolClip& clip : protocol.clips) grips_.push_back(sheet_.gripped(clip.grip));
    Random random(stream_seed(options.seed, "uneven"));
    for (int n = 0; n < sheet_.height_count(); ++n)
      x_[sheet_.z_of(n)] = -options.uneven_m * (1.0 + random.uniform());
  }

  const Sheet& sheet() const { return sheet_; }
  const Eigen::VectorXd& x() const { return x_; }
  int iterations() const { return iterations_; }

  /// In one step, or in as many as it takes.
  bool go_to(const ProtocolFrame& frame) {
    constexpr int kMostSteps = 16;
    for (int steps = 1; steps <= kMostSteps; steps *= 4) {
      const Sheet sheet_before = sheet_;
      const Eigen::VectorXd x_before = x_;
      bool ok = true;
      sheet_.set_step(frame.duration_s / steps);
      for (int k = 1; k <= steps && ok; ++k) ok = step_to(frame, static_cast<double>(k) / steps);
      if (ok) {
        if (!frame.poses.empty()) poses_ = frame.poses;
        return true;
      }
      sheet_ = sheet_before;
      x_ = x_before;
      if (frame.table) return false;
    }
    return false;
  }

  /// What cords bear at a clip in the last frame: the cloth's pull and the clip's weight.
  Eigen::Vector3d clip_force_N(std::size_t clip) const {
    Eigen::Vector3d sum(0.0, 0.0, kGravity_m_s2 * protocol_.clips[clip].mass_kg);
    for (const int n : grips_[clip].plane) sum.head<2>() += gradient_.segment<2>(Sheet::x_of(n));
    for (const int n : grips_[clip].height) sum.z() += gradient_[sheet_.z_of(n)];
    return sum;
  }

 private:
  bool step_to(const ProtocolFrame& frame, double share) {
    std::vector<int> held;
    const auto put = [&](const Gripped& grip, const ClipPose& pose) {
      for (const int n : grip.plane) {
        x_.segment<2>(Sheet::x_of(n)) =
            pose.rotation.topLeftCorner<2, 2>() * sheet_.place(n) + pose.position_m.head<2>();
        held.insert(held.end(), {Sheet::x_of(n), Sheet::x_of(n) + 1});
      }
      for (const int n : grip.height) {
        x_[sheet_.z_of(n)] = pose.position_m.z();
        held.push_back(sheet_.z_of(n));
      }
    };
    for (std::size_t c = 0; c < grips_.size(); ++c)
      put(grips_[c], between(poses_[c], frame.poses[c], share));
    if (frame.table) put(sheet_.gripped(*frame.table), ClipPose{});
    SheetSolver solver(sheet_, held);
    const SheetRest rest = solver.solve(x_, tolerance_);
    iterations_ += rest.iterations;
    if (!rest.converged) return false;
    sheet_.advance(x_);
    gradient_ = solver.gradient();
    return true;
  }

  const Protocol& protocol_;
  Sheet sheet_;
  Eigen::VectorXd x_;
  Eigen::VectorXd gradient_;
  std::vector<ClipPose> poses_;
  std::vector<Gripped> grips_;
  SheetTolerance tolerance_;
  int iterations_ = 0;
};

}  // namespace

std::vector<Eigen::Vector2d> irregular_places(double side_m, int count, std::uint64_t seed) {
  Random random(stream_seed(seed, "places"));
  const int cells = std::max(1, static_cast<int>(std::lround(std::sqrt(count))));
  std::vector<Eigen::Vector2d> places;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const double u = (i + random.uniform()) / cells, v = (j + random.uniform()) / cells;
      places.emplace_back(side_m * u, side_m * v);
    }
  return places;
}

SheetTwin run_protocol(const Fabric& fabric, const Protocol& protocol,
                       const std::vector<Eigen::Vector2d>& places_m,
                       const SheetTwinOptions& options) {
  SheetTwin twin;
  twin.places_m = places_m;
  Rig rig(fabric, protocol, options);
  twin.unknowns = rig.sheet().unknown_count();
  for (std::size_t f = 0; f < protocol.frames.size(); ++f) {
    if (!rig.go_to(protocol.frames[f])) {
      twin.failure = protocol.name + ", frame " + std::to_string(f + 1) + ": no rest found";
      break;
    }
    Eigen::Matrix3Xd& positions =
        twin.positions_m.emplace_back(3, static_cast<Eigen::Index>(places_m.size()));
    for (std::size_t k = 0; k < places_m.size(); ++k)
      positions.col(static_cast<Eigen::Index>(k)) = rig.sheet().position(rig.x(), places_m[k]);
    auto& forces = twin.clip_force_N.emplace_back();
    for (std::size_t c = 0; c < protocol.clips.size(); ++c) forces.push_back(rig.clip_force_N(c));
  }
  twin.iterations = rig.iterations();
  return twin;
}

}  // namespace tenter::twin
