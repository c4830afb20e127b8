// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/points/loops_of_captures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/estimation/thinning.h"
#include "server/jobs/friction_test/axis_of_cloth.h"

namespace tenter::jobs {
namespace {

using capture::AxisState;
using estimation::Curves;

constexpr int kReadingsPerBranch = 60;

double range_in(const Curves& curves, const estimation::CurveRun& run, int component) {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -lo;
  for (int i = run.first; i < run.last; ++i) {
    const double q = curves.path.q[static_cast<std::size_t>(i)][component];
    lo = std::min(lo, q);
    hi = std::max(hi, q);
  }
  return hi - lo;
}

/// Whether a run strains the component to and fro, and the others not at all where they are held.
bool is_loop(const Curves& curves, const estimation::CurveRun& run, int component) {
  const double range = range_in(curves, run, component);
  constexpr double kStill = 0.02;
  for (int other = 0; other < 3; ++other)
    if (other != component && !curves.path.is_free[static_cast<std::size_t>(other)] &&
        range_in(curves, run, other) > kStill * range)
      return false;
  bool loads = false;
  bool unloads = false;
  for (const estimation::Block& block : curves.blocks) {
    if (block.first < run.first || block.last > run.last) continue;
    const double way = curves.path.q[static_cast<std::size_t>(block.last - 1)][component] -
                       curves.path.q[static_cast<std::size_t>(block.first)][component];
    loads = loads || way > 0.2 * range;
    unloads = unloads || way < -0.2 * range;
  }
  // a hold or a single way says of friction what the loops beside it do not contradict
  return range > 0.0 && (loads || unloads);
}

bool turns_in(const Curves& curves, const estimation::CurveRun& run, int component) {
  bool up = false;
  bool down = false;
  for (const estimation::Block& block : curves.blocks) {
    if (block.first < run.first || block.last > run.last) continue;
    up = up || block.branch == capture::Branch::load;
    down = down || block.branch == capture::Branch::unload;
  }
  return up && down && range_in(curves, run, component) > 0.0;
}

/// The runs alone that were chosen, and no other stress than that of the component; what the other
/// strains do is not asked for.
capture::Capture reduced(const capture::Capture& capture, const std::vector<bool>& keeps,
                         const char* component) {
  capture::Capture part = capture;
  std::vector<int> place(capture.runs.size(), -1);
  part.runs.clear();
  for (std::size_t r = 0; r < capture.runs.size(); ++r)
    if (keeps[r]) {
      place[r] = static_cast<int>(part.runs.size());
      part.runs.push_back(capture.runs[r]);
    }
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < capture.frame_count(); ++i)
    if (place[static_cast<std::size_t>(capture.run[i])] >= 0) frames.push_back(i);
  const auto choose = [&](auto& values) {
    if (values.empty()) return;
    for (std::size_t k = 0; k < frames.size(); ++k) values[k] = values[frames[k]];
    values.resize(frames.size());
  };
  choose(part.frame);
  choose(part.run);
  choose(part.phase);
  choose(part.branch);
  choose(part.time_s);
  for (int& run : part.run) run = place[static_cast<std::size_t>(run)];
  for (capture::Channel& channel : part.channels) {
    choose(channel.values);
    choose(channel.sigma_per_frame);
  }
  std::erase_if(part.stresses,
                [&](const capture::StressAssignment& s) { return s.component != component; });
  (component[0] == 'x' ? part.kinematics.y : part.kinematics.x) = AxisState{};
  part.kinematics.xy = {.fixed_value = 0.0};
  return part;
}

struct ComponentLoops {
  std::vector<std::pair<std::string, capture::Capture>> captures;
  int runs = 0;
  int passed_over = 0;
  bool turns = false;
};

/// Of one direction of the cloth, "u" or "v".
Expected<ComponentLoops> component_loops(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const std::string& axis) {
  ComponentLoops loops;
  for (const auto& [id, capture] : captures) {
    const std::string along = axis_of_cloth(capture.specimen.axis_angle_rad);
    if (along.empty()) continue;
    const int component = along == axis ? 0 : 1;
    const AxisState& state = component == 0 ? capture.kinematics.x : capture.kinematics.y;
    const auto curves = estimation::make_curves(capture, id);
    if (!curves) return tl::unexpected(curves.error());
    const bool has_load = std::any_of(
        curves->channels.begin(), curves->channels.end(),
        [&](const auto& channel) { return channel.is_stress && channel.component == component; });
    if (state.role != AxisState::Role::prescribed || !has_load) continue;
    std::vector<bool> keeps(capture.runs.size(), false);
    bool any = false;
    for (std::size_t r = 0; r < curves->runs.size(); ++r) {
      keeps[r] = is_loop(*curves, curves->runs[r], component);
      any = any || keeps[r];
      loops.turns = loops.turns || (keeps[r] && turns_in(*curves, curves->runs[r], component));
      ++(keeps[r] ? loops.runs : loops.passed_over);
    }
    if (any) loops.captures.emplace_back(id, reduced(capture, keeps, component == 0 ? "x" : "y"));
  }
  return loops;
}

Expected<void> add_readings(const capture::Capture& capture, const std::string& id, int component,
                            estimation::LoopTable& table) {
  const auto whole = estimation::make_curves(capture, id);
  if (!whole) return tl::unexpected(whole.error());
  if (whole->dropped_frames > 0)
    return bad_input("capture \"" + capture.title + "\": " + std::to_string(whole->dropped_frames) +
                     " stretches are missing; what was done in between cannot be left out");
  std::vector<std::vector<bool>> none;
  for (const auto& channel : whole->channels) none.emplace_back(channel.measured.size(), false);
  const Curves curves = estimation::thin(*whole, kReadingsPerBranch, none);
  const auto load = std::find_if(
      curves.channels.begin(), curves.channels.end(),
      [&](const auto& channel) { return channel.is_stress && channel.component == component; });
  const int before = table.readings.empty() ? 0 : table.readings.back().branch + 1;
  for (std::size_t r = 0; r < curves.runs.size(); ++r) {
    const bool begins =
        r == 0 || capture.protocol.history == capture::Protocol::History::virgin_each_run;
    if (begins) table.beginnings.push_back(static_cast<int>(table.readings.size()));
    for (int i = curves.runs[r].first; i < curves.runs[r].last; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double stretch = curves.path.q[k][component];
      if (!std::isfinite(load->measured[k]))
        return bad_input("capture \"" + capture.title + "\", frame " +
                         std::to_string(curves.frame[k]) + ": no stress");
      table.readings.push_back(
          {0.5 * (stretch * stretch - 1.0), load->measured[k], before + curves.block_of[k]});
    }
  }
  table.load_noise = std::max(table.load_noise, load->sigma);
  return {};
}

}  // namespace

Expected<LoopsOfCaptures> loops_of(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const std::string& direction) {
  std::optional<ComponentLoops> chosen;
  LoopsOfCaptures result;
  for (const char* axis : {"u", "v"}) {
    const std::string word = axis[0] == 'u' ? "weft" : "warp";
    if (!direction.empty() && direction != word) continue;
    auto loops = component_loops(captures, axis);
    if (!loops) return tl::unexpected(loops.error());
    if (!loops->turns) continue;
    if (chosen)
      return bad_input(
          "options.direction: there are loops along weft and along warp; say which (weft or warp)");
    chosen = std::move(*loops);
    result.measure = std::string("green_") + axis;
  }
  if (!chosen)
    return bad_input(
        "captures: no run strains " + (direction.empty() ? "weft or warp" : direction) +
        " alone, to and fro, with its stretch imposed and its stress measured: that is what a "
        "loop needs");
  for (const auto& [id, capture] : chosen->captures) {
    const bool is_along =
        axis_of_cloth(capture.specimen.axis_angle_rad) == result.measure.substr(6);
    if (auto ok = add_readings(capture, id, is_along ? 0 : 1, result.table); !ok)
      return tl::unexpected(ok.error());
  }
  result.captures = std::move(chosen->captures);
  result.runs = chosen->runs;
  result.runs_passed_over = chosen->passed_over;
  return result;
}

}  // namespace tenter::jobs
