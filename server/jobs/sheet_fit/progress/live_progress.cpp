// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/live_progress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/model/catalogue.h"
#include "common/model/export/term_curve.h"

namespace tenter::jobs {

namespace {
constexpr std::chrono::milliseconds kEvery{50};
constexpr std::chrono::milliseconds kSilent{1000};
// of the whole job; reading comes before, comparison and writing after
constexpr double kFrom = 0.04;
constexpr double kTo = 0.9;
}  // namespace

void LiveProgress::begin(std::size_t stages, std::size_t done) {
  const std::lock_guard lock(mutex_);
  stages_ = std::max<std::size_t>(1, stages);
  done_ = done;
  last_ = {"stages",
           done > 0 ? std::to_string(done) + " stages were done by an earlier attempt" : "", 0, 0.0,
           fraction()};
  report_(last_);
}

void LiveProgress::frame(const estimation::StageFrame& frame) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (!is_told(frame.stage, now)) return;
  if (now < next_ && last_.stage == frame.stage) return;
  next_ = now + kEvery;
  if (last_.stage != frame.stage) last_.iteration = 0;
  last_.stage = frame.stage;
  last_.detail = "frame " + std::to_string(frame.at.frame + 1) + " of " +
                 std::to_string(frame.at.sequence.frames.size()) + ", " + frame.at.sequence.name +
                 "; " + values_in_words(frame.model, frame.at.parameters);
  last_.fraction = fraction();
  report_(last_);
}

void LiveProgress::iteration(const estimation::StageProgress& progress) {
  const std::lock_guard lock(mutex_);
  if (!is_told(progress.stage, std::chrono::steady_clock::now())) return;
  last_.stage = progress.stage;
  last_.iteration = progress.iteration;
  last_.cost = progress.cost;
  last_.fraction = fraction();
  report_(last_);
}

void LiveProgress::stages_done(std::size_t done) {
  const std::lock_guard lock(mutex_);
  done_ = done;
  told_.clear();
}

bool LiveProgress::is_told(const std::string& stage, std::chrono::steady_clock::time_point now) {
  if (told_.empty() || now - heard_ > kSilent) told_ = stage;
  if (told_ != stage) return false;
  heard_ = now;
  return true;
}

double LiveProgress::fraction() const {
  const double share = static_cast<double>(done_) / static_cast<double>(stages_);
  return kFrom + (kTo - kFrom) * std::min(1.0, share);
}

namespace {

/// Stress over strain in eight steps of height, from the lowest of zero and all to the largest.
std::string sparkline(const model::Term& term, const Eigen::VectorXd& values) {
  constexpr int kCells = 8;
  constexpr const char* kHeights[] = {"\u2581", "\u2582", "\u2583", "\u2584",
                                      "\u2585", "\u2586", "\u2587", "\u2588"};
  model::Law law = term.law;
  if (law.parameters.size() < 2 || !(law.range_hi > law.range_lo)) return "";
  for (std::size_t j = 0; j < law.parameters.size(); ++j)
    law.parameters[j].value = values[static_cast<Eigen::Index>(j)];
  const model::StrainRow* row = model::find_strain(term.strain.name);
  const auto curve = model::TermCurve::of(law, row ? row->domain : model::Domain::membrane);
  if (!curve) return "";
  std::array<double, kCells> stress{};
  for (int i = 0; i < kCells; ++i)
    stress[static_cast<std::size_t>(i)] =
        curve->stress(law, law.range_lo + (law.range_hi - law.range_lo) * (i + 1.0) / kCells);
  const auto [least, most] = std::minmax_element(stress.begin(), stress.end());
  const double lo = std::min(0.0, *least), hi = std::max(0.0, *most);
  if (!(hi > lo) || !std::isfinite(hi - lo)) return "";
  std::string words = " ";
  for (const double value : stress)
    words += kHeights[std::clamp(static_cast<int>(8.0 * (value - lo) / (hi - lo)), 0, 7)];
  return words;
}

}  // namespace

std::string values_in_words(const model::Model& model, const Eigen::VectorXd& parameters) {
  std::string words;
  Eigen::Index k = 0;
  for (const model::Term& term : model.terms) {
    const Eigen::Index first = k;
    std::string values;
    for (const model::Parameter& p : term.law.parameters) {
      if (k >= parameters.size()) return words;
      char value[32];
      std::snprintf(value, sizeof value, " %.4g", parameters[k++]);
      if (!p.fixed) values += value;
    }
    if (values.empty()) continue;
    values += sparkline(term, parameters.segment(first, k - first));
    if (words.size() + term.id.size() + values.size() + 2 > kMostWords) return words + ", ...";
    words += (words.empty() ? "" : ", ") + term.id + values;
  }
  return words;
}

}  // namespace tenter::jobs
