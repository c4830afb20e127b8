// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/gain.h"

#include <optional>

#include "server/diagnosis/verdicts/score.h"
#include "server/estimation/hold_out.h"

namespace tenter::diagnosis {
namespace {

std::optional<estimation::HeldOut> held_out(const Reference& at, const DataPointer& data,
                                            const estimation::Folds& folds) {
  auto evaluator = estimation::Evaluator::make(at.model, data);
  if (!evaluator) return std::nullopt;
  estimation::FitOptions options;
  options.max_iterations = 40;
  estimation::HeldOut result = estimation::cross_validate(*evaluator, at.model, folds, options);
  if (!result.usable) return std::nullopt;
  return result;
}

/// The first kind of folds that leaves enough behind to determine what `extended` added.
std::optional<estimation::Folds> choose_folds(const Reference& extended, const Reference& baseline,
                                              const DataPointer& data, const std::string& leave_out,
                                              std::string* chosen) {
  for (const std::string& kind : estimation::fold_kinds()) {
    if (leave_out != "auto" && leave_out != kind) continue;
    estimation::Folds folds = estimation::make_folds(*data, data->rows(), kind);
    estimation::keep_determined(folds, extended.fit,
                                estimation::added_parameters(extended.model, baseline.model));
    if (folds.training.size() < 2) continue;
    if (chosen) *chosen = kind;
    return folds;
  }
  return std::nullopt;
}

}  // namespace

void measure_gain(Diagnosis& d, const Options& options, const Control& control) {
  const auto rows = d.data->rows();
  d.before = score_of(*d.data, rows, d.baseline.fit.residuals, -1);
  d.after = score_of(*d.data, rows, d.extended.fit.residuals, -1);
  d.noise_floor = noise_floor_of(*d.data, rows, d.noise, -1);
  control.report({"held out", "", 0, d.extended.fit.chi2, 0.9});
  std::optional<estimation::HeldOut> before;
  std::optional<estimation::HeldOut> after;
  const auto folds =
      choose_folds(d.extended, d.baseline, d.data, options.leave_out, &d.held_out_kind);
  if (folds) {
    before = held_out(d.baseline, d.data, *folds);
    after = held_out(d.extended, d.data, *folds);
  }
  if (folds && (!before || !after))
    d.checklist.push_back({"WARNING", "the gain on left-out " + d.held_out_kind + " is not known",
                           "a refit without some of them failed"});
  if (before) d.held_out_before = score_of(*d.data, rows, before->residuals, -1);
  if (after) d.held_out_after = score_of(*d.data, rows, after->residuals, -1);
  for (int i = 0; i < static_cast<int>(d.curves.size()); ++i) {
    CaptureScore score;
    score.before = score_of(*d.data, rows, d.baseline.fit.residuals, i);
    score.after = score_of(*d.data, rows, d.extended.fit.residuals, i);
    score.noise_floor = noise_floor_of(*d.data, rows, d.noise, i);
    if (before) score.held_out_before = score_of(*d.data, rows, before->residuals, i);
    if (after) score.held_out_after = score_of(*d.data, rows, after->residuals, i);
    d.captures.push_back(score);
  }
}

bool predicts_as_well(const Reference& other, const Reference& current, const Reference& baseline,
                      const DataPointer& data, const std::string& leave_out) {
  const auto folds = choose_folds(current, baseline, data, leave_out, nullptr);
  if (!folds) return true;
  const auto now = held_out(current, data, *folds);
  const auto then = held_out(other, data, *folds);
  if (!now || !then) return !now;
  return then->chi2 <= now->chi2;
}

}  // namespace tenter::diagnosis
