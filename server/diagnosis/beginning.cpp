// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/beginning.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "server/diagnosis/checks/refined_solve.h"
#include "server/diagnosis/prepare.h"
#include "server/diagnosis/trials/gain.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/diagnosis/verdicts/verdicts.h"

namespace tenter::diagnosis {
namespace {

/// Readings beside a corner are no proof of misreading: within a few frames of a slip that was
/// found, and, where the model still misses something, of a reversal.
bool beside_an_event(const Diagnosis& d, const estimation::Outlier& o, bool near_reversals) {
  constexpr int kFrames = 3;
  const estimation::Curves& curves = d.curves[static_cast<std::size_t>(o.curve)];
  for (const model::SensorCorrection& c : d.extended.model.corrections)
    if (c.type == "clip_slip" && c.capture == curves.id &&
        std::abs(c.parameters[1].value - o.frame) <= kFrames)
      return true;
  if (!near_reversals) return false;
  const estimation::Block& block =
      curves.blocks[static_cast<std::size_t>(curves.block_of[static_cast<std::size_t>(o.frame)])];
  return o.frame - block.first < kFrames || block.last - 1 - o.frame < kFrames;
}

/// Of the readings set aside, those that a model does not reach either; a sharp corner that the
/// baseline lacked is no misreading.
std::vector<estimation::Outlier> not_reached(const Diagnosis& d, const model::Model& model) {
  const auto whole = std::make_shared<const estimation::DataSet>(whole_data(d, {}));
  auto evaluator = estimation::Evaluator::make(model, whole);
  Eigen::VectorXd residuals;
  if (!evaluator || evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr) !=
                        mechanics::PathStatus::ok)
    return d.outliers;
  std::set<std::tuple<int, int, int>> still;
  for (const estimation::Outlier& o :
       estimation::find_outliers(*whole, evaluator->rows(), residuals, {}))
    still.insert({o.curve, o.channel, o.frame});
  std::vector<estimation::Outlier> left = d.outliers;
  std::erase_if(left, [&](const estimation::Outlier& o) {
    return !still.contains({o.curve, o.channel, o.frame});
  });
  return left;
}

/// What the effects found say of the data: that repeats differ much less without them, or that
/// readings which were set aside were none to set aside.
struct Reweighed {
  Weighed weighed;
  std::vector<estimation::Outlier> outliers;
  std::string why;
};

Expected<std::optional<Reweighed>> reweigh_by(const Diagnosis& d, const Reference& current,
                                              const Options& options) {
  constexpr std::size_t kFewest = 3;  // readings that come back, and half of those set aside
  Reweighed result;
  result.outliers = d.outliers.empty() ? d.outliers : not_reached(d, current.model);
  const std::size_t back = d.outliers.size() - result.outliers.size();
  if (back >= kFewest && back >= result.outliers.size()) {
    const auto data = std::make_shared<const estimation::DataSet>(
        thinned(whole_data(d, result.outliers), options.max_frames_per_block));
    auto found = make_reference(current.model, data, {});
    if (!found) return tl::unexpected(found.error());
    std::tie(result.weighed.noise, result.weighed.data) =
        reweigh(data, data->rows(), found->fit.residuals);
    result.why = std::to_string(back) + " readings are reached that were set aside: weighed anew";
    return result;
  }
  auto weighed = weigh_without(d.data, d.noise, current);
  if (!weighed) return std::nullopt;
  result.outliers = d.outliers;
  result.why =
      "repeats differ by " + in_percent(weighed->quieter) + " of what they did: weighed anew";
  result.weighed = std::move(*weighed);
  return result;
}

/// Means over fewer frames could be had.
bool can_be_finer(const Diagnosis& d, const Options& options) {
  constexpr int kMostFrames = 400;
  if (options.max_frames_per_block >= kMostFrames) return false;
  for (const estimation::Curves& curves : d.curves)
    for (const estimation::Block& block : curves.blocks)
      if (block.last - block.first > options.max_frames_per_block) return true;
  return false;
}

}  // namespace

void confirm_outliers(Diagnosis& d) {
  if (d.outliers.empty()) return;
  d.outliers = not_reached(d, d.extended.model);
  const bool rough = misses_more_than_noise(d, d.extended.fit);
  std::erase_if(d.outliers,
                [&](const estimation::Outlier& o) { return beside_an_event(d, o, rough); });
}

Expected<Diagnosis> begin(const Request& request, const Control& control) {
  auto prepared = prepare(request, control);
  if (!prepared) return tl::unexpected(prepared.error());
  Diagnosis d;
  d.curves = std::move(prepared->curves);
  d.outliers = std::move(prepared->outliers);
  d.data = prepared->data;
  d.noise = std::move(prepared->noise);
  d.baseline = std::move(prepared->baseline);
  d.path.push_back(step_of("start", "", request.model.name, d.baseline, d));
  return d;
}

Expected<Diagnosis> begin_refined(Request& request, const Control& control) {
  auto d = begin(request, control);
  if (!d) return d;
  control.report({"refined solve", "", 0, d->baseline.fit.chi2, 0.08});
  const auto keep_on = [&] { return !control.stop.stop_requested(); };
  RefinedSolve solve = refined_solve(d->baseline, d->data, whole_data(*d, d->outliers),
                                     request.options.seed, keep_on);
  if (control.stop.stop_requested())
    return fail(ErrorKind::cancelled, "stopped during the refined solve");
  if (solve.effect == "mesh_resolution" && can_be_finer(*d, request.options)) {
    request.options.max_frames_per_block *= 2;
    return begin_refined(request, control);
  }
  check_refined_solve(*d, solve, "the baseline");
  if (!solve.effect.empty())
    d->verdicts.push_back(numerical_verdict(*d, solve, request.options.seed));
  if (!solve.better) return d;
  Request again = request;
  again.model = std::move(solve.better->model);
  auto better = begin(again, control);
  if (!better) return better;
  better->verdicts = std::move(d->verdicts);
  better->checklist = std::move(d->checklist);
  return better;
}

bool begin_anew(Diagnosis& d, const Reference& current, const std::vector<Accepted>& accepted,
                const Request& request) {
  if (accepted.empty()) return false;
  auto anew = reweigh_by(d, current, request.options);
  if (anew && !*anew) return false;
  auto baseline = anew ? make_reference(d.baseline.model, (*anew)->weighed.data, {})
                       : tl::unexpected(anew.error());
  if (!baseline) {
    d.checklist.push_back({"WARNING", "what was found has no say in what the data are worth",
                           baseline.error().message});
    return false;
  }
  std::string found;
  for (const Accepted& entry : accepted)
    if (found.find(entry.trial.effect->id) == std::string::npos)
      found += (found.empty() ? "" : ", ") + entry.trial.effect->id;
  d.noise = std::move((*anew)->weighed.noise);
  d.data = std::move((*anew)->weighed.data);
  d.outliers = std::move((*anew)->outliers);
  d.baseline = std::move(*baseline);
  d.path = {step_of("start", "", request.model.name + "; with " + found + " " + (*anew)->why,
                    d.baseline, d)};
  return true;
}

}  // namespace tenter::diagnosis
