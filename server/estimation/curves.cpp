// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "server/estimation/instrument/last_motion.h"

namespace tenter::estimation {
namespace {

using capture::AxisState;
using capture::Capture;
using capture::Channel;
using capture::Quantity;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Distance of two tracked points, frame by frame.
std::vector<double> point_distance(const Capture& capture, const std::string& a,
                                   const std::string& b) {
  std::vector<double> squared(capture.frame_count(), 0.0);
  for (const char coordinate : {'x', 'y', 'z'}) {
    const Channel* from = nullptr;
    const Channel* to = nullptr;
    for (const Channel& c : capture.channels) {
      if (c.quantity != Quantity::position || c.coordinate != coordinate) continue;
      if (c.point == a) from = &c;
      if (c.point == b) to = &c;
    }
    if (!from || !to) continue;
    for (std::size_t f = 0; f < squared.size(); ++f) {
      const double d = to->values[f] - from->values[f];
      squared[f] += d * d;
    }
  }
  for (double& s : squared) s = std::sqrt(s);
  return squared;
}

/// Lengths to stretches by the reference that the axis declares.
void divide_by_reference(const Capture& capture, const AxisState& axis,
                         std::vector<double>& length) {
  double reference = axis.reference_length_m;
  int run = -1;
  for (std::size_t f = 0; f < length.size(); ++f) {
    const bool first =
        axis.reference == AxisState::Reference::first_frame_of_run
            ? capture.run[f] != run
            : axis.reference == AxisState::Reference::first_frame_of_capture && f == 0;
    if (first) reference = length[f];
    run = capture.run[f];
    length[f] /= reference;
  }
}

/// Stretch (shear for xy) of one component over all frames of the capture.
std::vector<double> component_values(const Capture& capture, const AxisState& axis) {
  if (axis.source == AxisState::Source::points) {
    std::vector<double> length = point_distance(capture, axis.point_a, axis.point_b);
    divide_by_reference(capture, axis, length);
    return length;
  }
  std::vector<double> values = capture.find(axis.channel)->values;
  switch (capture.find(axis.channel)->quantity) {
    case Quantity::strain:
      for (double& v : values) v += 1.0;
      break;
    case Quantity::displacement:
      for (double& v : values) v = 1.0 + v / axis.reference_length_m;
      break;
    case Quantity::length:
      divide_by_reference(capture, axis, values);
      break;
    default:
      break;
  }
  return values;
}

/// N/m per SI unit of the channel.
Expected<double> stress_factor(const Capture& capture, const Channel& channel, int component) {
  const capture::Specimen& s = capture.specimen;
  switch (channel.quantity) {
    case Quantity::membrane_stress:
      return 1.0;
    case Quantity::stress:
      if (s.thickness_m) return *s.thickness_m;
      return bad_input("specimen \"" + s.name + "\": channel \"" + channel.name +
                       "\" is a stress, and without a thickness it gives no force per width");
    case Quantity::force: {
      const std::optional<double> width = component == 1 && s.width_y_m ? s.width_y_m : s.width_m;
      if (width) return 1.0 / *width;
      if (s.cross_section_m2) return s.thickness_m.value_or(1e-3) / *s.cross_section_m2;
      return bad_input("specimen \"" + s.name + "\": channel \"" + channel.name +
                       "\" is a force, and the specimen has neither width nor cross-section");
    }
    default:
      return bad_input("channel \"" + channel.name + "\" is no force, stress or membrane stress");
  }
}

int component_index(const std::string& name) {
  if (name == "x") return 0;
  if (name == "y") return 1;
  return name == "xy" ? 2 : -1;
}

/// A time for every frame that never falls over the session, and the duration of each step. Without
/// a clock the path length over the declared rate stands for it, or over one per cent a second
/// where not even that is known.
void make_clock(const Capture& capture, const std::vector<int>& kept, Curves& curves) {
  const auto n = kept.size();
  curves.clock_s.assign(n, 0.0);
  curves.path.duration_s.assign(n, 0.0);
  curves.time_base = !capture.time_s.empty()               ? TimeBase::clock
                     : capture.protocol.nominal_rate_per_s ? TimeBase::nominal_rate
                                                           : TimeBase::none;
  constexpr double kPseudoRate = 0.01;
  double shift = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto f = static_cast<std::size_t>(kept[i]);
    const bool starts =
        i == 0 || capture.run[f] != capture.run[static_cast<std::size_t>(kept[i - 1])];
    if (curves.time_base == TimeBase::clock) {
      const double t = capture.time_s[f];
      // a clock that restarts with the run goes on where the run before ended
      if (starts && i > 0 && t + shift < curves.clock_s[i - 1]) shift = curves.clock_s[i - 1] - t;
      curves.clock_s[i] = t + shift;
      if (!starts) curves.path.duration_s[i] = curves.clock_s[i] - curves.clock_s[i - 1];
    } else {
      const double rate = capture.protocol.nominal_rate_per_s.value_or(kPseudoRate);
      const double length =
          i == 0 || starts ? 0.0 : (curves.path.q[i] - curves.path.q[i - 1]).norm();
      curves.path.duration_s[i] = length / rate;
      curves.clock_s[i] = (i == 0 ? 0.0 : curves.clock_s[i - 1]) + curves.path.duration_s[i];
    }
  }
}

/// A run goes on from the one before where the specimen continues and the imposed strain does not
/// jump.
void mark_starts(const Capture& capture, Curves& curves) {
  const auto n = curves.path.q.size();
  curves.path.start.assign(n, mechanics::FrameStart::next);
  Eigen::Vector3d lo = curves.path.q.front();
  Eigen::Vector3d hi = lo;
  for (const Eigen::Vector3d& q : curves.path.q) {
    lo = lo.cwiseMin(q);
    hi = hi.cwiseMax(q);
  }
  constexpr double kJump = 0.03;  // of the range
  for (const CurveRun& run : curves.runs) {
    const auto f = static_cast<std::size_t>(run.first);
    if (f == 0) continue;
    if (capture.protocol.history == capture::Protocol::History::virgin_each_run) {
      curves.path.start[f] = mechanics::FrameStart::virgin;
      continue;
    }
    bool jumps = false;
    for (int i = 0; i < 3; ++i) {
      if (curves.path.is_free[static_cast<std::size_t>(i)]) continue;
      const double step = std::abs(curves.path.q[f][i] - curves.path.q[f - 1][i]);
      if (step > kJump * (hi[i] - lo[i]) && step > 1e-9) jumps = true;
    }
    curves.path.start[f] = jumps ? mechanics::FrameStart::rested : mechanics::FrameStart::next;
    if (!jumps && curves.time_base == TimeBase::clock)
      curves.path.duration_s[f] = curves.clock_s[f] - curves.clock_s[f - 1];
  }
}

void make_runs_and_blocks(const Capture& capture, const std::vector<int>& kept, Curves& curves) {
  const std::string repeated = capture.specimen.name + "/" + capture.protocol.name + "/";
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const auto f = static_cast<std::size_t>(kept[i]);
    const capture::Run& run = capture.runs[static_cast<std::size_t>(capture.run[f])];
    const bool new_run =
        i == 0 || capture.run[f] != capture.run[static_cast<std::size_t>(kept[i - 1])];
    if (new_run) {
      CurveRun entry;
      entry.number = run.number;
      // without a group of its own a run can still be repeated by the same run of another capture
      entry.group =
          repeated + (run.group.empty() ? "#" + std::to_string(curves.runs.size() + 1) : run.group);
      entry.first = static_cast<int>(i);
      curves.runs.push_back(entry);
    }
    const bool new_block =
        new_run || capture.branch[f] != capture.branch[static_cast<std::size_t>(kept[i - 1])];
    if (new_block) {
      Block block;
      block.run = static_cast<int>(curves.runs.size()) - 1;
      block.branch = capture.branch[f];
      block.first = static_cast<int>(i);
      curves.blocks.push_back(block);
    }
    curves.blocks.back().last = static_cast<int>(i) + 1;
    curves.runs.back().last = static_cast<int>(i) + 1;
    curves.block_of.push_back(static_cast<int>(curves.blocks.size()) - 1);
  }
}

}  // namespace

const char* component_name(int component) {
  static constexpr const char* kNames[] = {"x", "y", "xy"};
  return kNames[component];
}

Expected<Curves> make_curves(const Capture& capture, const std::string& id) {
  if (capture.sheet)
    return bad_input(capture.title +
                     ": is a deforming sheet; curves are made of captures with homogeneous strain");
  Curves curves;
  curves.id = id;
  curves.title = capture.title;
  curves.specimen = capture.specimen.name;
  curves.protocol = capture.protocol.name;
  curves.path.axis_angle_rad = capture.specimen.axis_angle_rad;

  const AxisState* axes[3] = {&capture.kinematics.x, &capture.kinematics.y, &capture.kinematics.xy};
  std::vector<double> values[3];
  for (int i = 0; i < 3; ++i) {
    const AxisState& axis = *axes[i];
    curves.path.is_free[static_cast<std::size_t>(i)] =
        axis.role == AxisState::Role::observed || axis.role == AxisState::Role::free;
    if (axis.role == AxisState::Role::prescribed || axis.role == AxisState::Role::observed)
      values[i] = component_values(capture, axis);
  }
  std::vector<int> kept;
  for (std::size_t f = 0; f < capture.frame_count(); ++f) {
    Eigen::Vector3d q(1.0, 1.0, 0.0);
    bool usable = true;
    for (int i = 0; i < 3; ++i) {
      if (axes[i]->role == AxisState::Role::fixed) q[i] = axes[i]->fixed_value;
      if (axes[i]->role == AxisState::Role::prescribed) q[i] = values[i][f];
      if (axes[i]->role == AxisState::Role::observed && std::isfinite(values[i][f]))
        q[i] = values[i][f];
      usable = usable && std::isfinite(q[i]);
    }
    if (!usable || q[0] <= 0.0 || q[1] <= 0.0) {
      ++curves.dropped_frames;
      continue;
    }
    curves.origin.push_back(static_cast<int>(kept.size()));
    kept.push_back(static_cast<int>(f));
    curves.path.q.push_back(q);
    curves.frame.push_back(capture.frame[f]);
  }
  if (kept.size() < 3)
    return bad_input(capture.title + ": fewer than three frames have a usable strain");
  make_runs_and_blocks(capture, kept, curves);
  make_clock(capture, kept, curves);
  mark_starts(capture, curves);

  for (const capture::StressAssignment& assignment : capture.stresses) {
    const Channel* channel = capture.find(assignment.channel);
    const int component = component_index(assignment.component);
    if (!channel || component < 0)
      return bad_input(capture.title + ": the stress of component \"" + assignment.component +
                       "\" has no channel \"" + assignment.channel + "\"");
    if (curves.path.is_free[static_cast<std::size_t>(component)]) continue;
    const Expected<double> factor = stress_factor(capture, *channel, component);
    if (!factor) return bad_input(capture.title + ": " + factor.error().message);
    ObservedChannel observed;
    observed.name = std::string("stress_") + component_name(component);
    observed.unit = "N/m";
    observed.component = component;
    observed.sigma = channel->sigma * *factor;
    observed.resolution = channel->resolution * *factor;
    for (const int f : kept) {
      observed.measured.push_back(channel->values[static_cast<std::size_t>(f)] * *factor);
      if (!channel->sigma_per_frame.empty())
        observed.sigma_per_frame.push_back(channel->sigma_per_frame[static_cast<std::size_t>(f)] *
                                           *factor);
    }
    curves.channels.push_back(std::move(observed));
  }
  for (int i = 0; i < 3; ++i) {
    if (axes[i]->role != AxisState::Role::observed) continue;
    ObservedChannel observed;
    observed.name = std::string(i == 2 ? "shear_" : "stretch_") + component_name(i);
    observed.unit = "1";
    observed.component = i;
    observed.is_stress = false;
    const Channel* channel =
        axes[i]->source == AxisState::Source::channel ? capture.find(axes[i]->channel) : nullptr;
    if (channel && (channel->quantity == Quantity::stretch ||
                    channel->quantity == Quantity::strain || channel->quantity == Quantity::shear))
      observed.sigma = channel->sigma;
    for (const int f : kept) observed.measured.push_back(values[i][static_cast<std::size_t>(f)]);
    curves.channels.push_back(std::move(observed));
  }
  if (curves.channels.empty())
    return bad_input(capture.title +
                     ": no stress and no free stretch was measured, there is nothing to fit");
  return curves;
}

std::vector<double> last_motions_of(const Curves& curves, int component) {
  constexpr double kLeastRange = 1e-6;
  const auto c = static_cast<std::size_t>(component);
  const std::size_t n = curves.frame_count();
  if (!curves.mean_last_motion[c].empty()) return curves.mean_last_motion[c];
  if (n == 0 || curves.path.is_free[c]) return std::vector<double>(n, 0.0);
  std::vector<double> strain;
  std::vector<bool> starts;
  for (std::size_t f = 0; f < n; ++f) {
    strain.push_back(curves.path.q[f][component]);
    starts.push_back(curves.path.start[f] != mechanics::FrameStart::next);
  }
  return last_motions(strain, starts, kLeastRange);
}

}  // namespace tenter::estimation
