// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/points/rate_question.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/diagnosis/prepare.h"
#include "server/diagnosis/verdicts/verdicts.h"

namespace tenter::jobs {
namespace {

using estimation::Block;
using estimation::Curves;

/// The load of the component that is strained most, frame by frame.
const estimation::ObservedChannel* load_of(const Curves& curves) {
  for (const auto& channel : curves.channels)
    if (channel.is_stress) return &channel;
  return nullptr;
}

/// Of holds that are long beside the run: a pause at a turn is none.
void look_at_hold(const Curves& curves, const Block& block, RateQuestion& question) {
  const auto* load = load_of(curves);
  const auto first = static_cast<std::size_t>(block.first);
  const auto last = static_cast<std::size_t>(block.last - 1);
  const double duration = curves.clock_s[last] - curves.clock_s[first];
  const estimation::CurveRun& run = curves.runs[static_cast<std::size_t>(block.run)];
  const double whole = curves.clock_s[static_cast<std::size_t>(run.last - 1)] -
                       curves.clock_s[static_cast<std::size_t>(run.first)];
  constexpr double kLong = 0.2;
  if (duration < kLong * whole || block.last - block.first < 3) return;
  double most = 0.0;  // of the run
  for (int i = run.first; i < run.last; ++i) {
    const double value = load->measured[static_cast<std::size_t>(i)];
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  }
  double highest = 0.0;  // of the hold
  for (std::size_t i = first; i <= last; ++i)
    if (std::isfinite(load->measured[i])) highest = std::max(highest, std::abs(load->measured[i]));
  if (!(most > 0.0) || !std::isfinite(load->measured[last])) return;
  const double fallen = (highest - std::abs(load->measured[last])) / most;
  if (question.fallen && *question.fallen >= fallen) return;
  question.fallen = fallen;
  question.hold_s = duration;
}

/// A run that goes to one end and back.
struct RunLoop {
  double reach = 0.0;  ///< largest stretch - smallest
  double rate = 0.0;   ///< way over time
  double lost = 0.0;   ///< work, J/m2
};

std::optional<RunLoop> loop_of(const Curves& curves, const estimation::CurveRun& run) {
  const auto* load = load_of(curves);
  const int component = load->component;
  RunLoop loop;
  double lo = 1e300, hi = -1e300, way = 0.0;
  for (int i = run.first; i < run.last; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double q = curves.path.q[k][component];
    lo = std::min(lo, q);
    hi = std::max(hi, q);
    if (i == run.first || !std::isfinite(load->measured[k]) ||
        !std::isfinite(load->measured[k - 1]))
      continue;
    const double step = q - curves.path.q[k - 1][component];
    way += std::abs(step);
    loop.lost += 0.5 * (load->measured[k] + load->measured[k - 1]) * step;
  }
  const double time = curves.clock_s[static_cast<std::size_t>(run.last - 1)] -
                      curves.clock_s[static_cast<std::size_t>(run.first)];
  loop.reach = hi - lo;
  const double back = std::abs(curves.path.q[static_cast<std::size_t>(run.last - 1)][component] -
                               curves.path.q[static_cast<std::size_t>(run.first)][component]);
  // closed well enough that what is left open is little of the work
  if (!(time > 0.0) || !(loop.reach > 0.0) || back > 0.1 * loop.reach || way < 1.5 * loop.reach)
    return std::nullopt;
  loop.rate = way / time;
  loop.lost /= way / (2.0 * loop.reach);  // of one cycle
  return loop;
}

/// Of two runs of about one amplitude, those whose rates are farthest apart.
void compare_rates(const std::vector<Curves>& all, RateQuestion& question) {
  std::vector<RunLoop> loops;
  for (const Curves& curves : all) {
    if (curves.time_base == estimation::TimeBase::none || !load_of(curves)) continue;
    for (const estimation::CurveRun& run : curves.runs)
      if (const auto loop = loop_of(curves, run)) loops.push_back(*loop);
  }
  for (const RunLoop& slow : loops)
    for (const RunLoop& fast : loops) {
      const double ratio = fast.rate / slow.rate;
      constexpr double kAlike = 0.05;
      if (ratio <= std::max(1.5, question.rate_ratio) || !(slow.lost > 0.0) ||
          std::abs(fast.reach / slow.reach - 1.0) > kAlike)
        continue;
      question.rate_ratio = ratio;
      question.loss_ratio = fast.lost / slow.lost;
    }
}

struct BestTrial {
  double chi2 = 0.0;
  double information = 1e300;
};

/// The best of the screen's viscosities beside the fitted model, refitted.
BestTrial best_viscosity(const diagnosis::Screen& screen, const diagnosis::Prepared& prepared) {
  BestTrial best{prepared.baseline.fit.chi2, 1e300};
  int tried = 0;
  for (const diagnosis::Candidate& candidate : screen.candidates) {
    constexpr int kTrials = 3;
    if (candidate.effect->id != "viscosity" || tried++ >= kTrials) continue;
    const diagnosis::Trial trial = diagnosis::refit(candidate, prepared.baseline, prepared.data);
    if (!trial.fit.usable) continue;
    const double information =
        diagnosis::information(trial.fit.chi2, diagnosis::free_count(trial.model), 1,
                               prepared.baseline.fit.effective_rows);
    if (information < best.information) best = {trial.fit.chi2, information};
  }
  return best;
}

/// What of the facts friction cannot do.
bool contradicts_friction(const RateQuestion& question) {
  constexpr double kFallen = 0.1;
  constexpr double kOtherWork = 0.15;
  return question.fallen.value_or(0.0) > kFallen ||
         std::abs(question.loss_ratio.value_or(1.0) - 1.0) > kOtherWork;
}

std::string share_text(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f %%", 100.0 * share);
  return text.data();
}

std::string ratio_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

std::string facts(const RateQuestion& question) {
  std::string words;
  if (question.fallen)
    words += " In a hold of " + ratio_text(question.hold_s) + " s the load fell by " +
             share_text(*question.fallen) + ".";
  if (question.loss_ratio)
    words += " At " + ratio_text(question.rate_ratio) +
             " times the rate a loop of one amplitude lost " + ratio_text(*question.loss_ratio) +
             " times the work.";
  if (!words.empty()) words += " Friction changes in neither.";
  return words;
}

}  // namespace

Expected<RateQuestion> ask_for_rate(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const model::Model& fitted, const diagnosis::Control& control) {
  diagnosis::Request request;
  request.captures = captures;
  request.model = fitted;
  request.options.leave_out = "none";
  auto prepared = diagnosis::prepare(request, control);
  if (!prepared) return tl::unexpected(prepared.error());
  const diagnosis::Excitation excitation = diagnosis::examine(prepared->data->curves);
  RateQuestion question;
  if (!excitation.splits_rate()) {
    question.words =
        "these captures cannot tell friction from viscosity: " +
        std::string(excitation.has_rate ? "their rates are less than a factor of three apart, and "
                                          "no strain is held"
                                        : "they have no times") +
        ". The same loop at two rates a decade apart and a hold of ten minutes would.";
    return question;
  }
  for (const Curves& curves : prepared->curves) {
    if (curves.time_base != estimation::TimeBase::clock || !load_of(curves)) continue;
    for (const Block& block : curves.blocks)
      if (block.branch == capture::Branch::hold) look_at_hold(curves, block, question);
  }
  compare_rates(prepared->curves, question);
  constexpr int kNullTwins = 200;
  const diagnosis::Screen screen =
      diagnosis::screen(prepared->baseline.model, prepared->baseline.fit, prepared->data,
                        prepared->noise, excitation, {kNullTwins, request.options.seed});
  if (control.stop.stop_requested()) return fail(ErrorKind::cancelled, "cancelled");
  const BestTrial best = best_viscosity(screen, *prepared);
  const double missed = prepared->baseline.fit.chi2;
  question.viscosity_share = missed > 0.0 ? 1.0 - best.chi2 / missed : 0.0;
  question.evidence =
      diagnosis::information(missed, diagnosis::free_count(prepared->baseline.model), 0,
                             prepared->baseline.fit.effective_rows) -
      best.information;
  constexpr double kDecisive = 10.0;  // as verdicts have it
  const bool is_rate = question.evidence > kDecisive && contradicts_friction(question);
  question.answer = is_rate ? RateAnswer::viscosity : RateAnswer::friction;
  const std::string explained = "viscosity explains " + share_text(question.viscosity_share) +
                                " of what stiffness and friction miss";
  question.words = is_rate
                       ? "this is no internal friction: the load depends on the rate of strain." +
                             facts(question) + " And " + explained + "."
                       : explained + "." + facts(question);
  return question;
}

}  // namespace tenter::jobs
