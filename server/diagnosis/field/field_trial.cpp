// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/field_trial.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "server/diagnosis/field/data/structure.h"

namespace tenter::diagnosis {
namespace {

FieldTrial trial_of(FieldFit fit) {
  FieldTrial result;
  result.trial.model = std::move(fit.at.model);
  result.trial.fit = std::move(fit.at.fit);
  result.trial.block_chi2 = std::move(fit.at.block_chi2);
  result.states = std::move(fit.states);
  return result;
}

FieldFit fit_of(const FieldTrial& trial, const FieldFit& before) {
  return {reference_of(trial.trial), trial.states, before.rows};
}

/// chi2 of one kind of channel of one sequence, by both models.
struct KindChi2 {
  double before = 0.0, after = 0.0, rows = 0.0;
  bool of_positions = false;
};

std::vector<KindChi2> chi2_by_kind(const FieldFit& before, const FieldTrial& after,
                                   const FieldData& data) {
  const std::vector<int> places = kind_places(data.sequences, before.rows);
  std::vector<KindChi2> kinds;
  for (std::size_t r = 0; r < places.size(); ++r) {
    const auto p = static_cast<std::size_t>(places[r]);
    if (kinds.size() <= p) kinds.resize(p + 1);
    const auto k = static_cast<Eigen::Index>(r);
    kinds[p].before += std::pow(before.at.fit.residuals[k], 2);
    kinds[p].after += std::pow(after.trial.fit.residuals[k], 2);
    kinds[p].rows += 1.0;
    const auto& sequence = data.sequences[static_cast<std::size_t>(before.rows[r].curve)];
    kinds[p].of_positions = before.rows[r].channel < 3 * static_cast<int>(sequence.points.size());
  }
  std::erase_if(kinds, [](const KindChi2& kind) { return kind.rows == 0.0; });
  return kinds;
}

/// A fault of cameras: forces gain by it only what they gain by anything.
bool is_of_points(const Variant& variant) {
  return !variant.corrections.empty() &&
         std::ranges::all_of(variant.corrections, [](const model::SensorCorrection& c) {
           return c.type.starts_with("camera_") || c.type == "occlusion_bias";
         });
}

/// A stiffness that differs over the material.
bool has_many_places(const Variant& variant) {
  constexpr std::size_t kMany = 9;
  return variant.parts_are_one && variant.append.size() >= kMany;
}

/// Largest share, over kinds of channels, of the noise's power there that is explained: forces are
/// few among thousands of positions.
double share_of_noise(const std::vector<KindChi2>& kinds, bool of_points) {
  double largest = 0.0;
  for (const KindChi2& kind : kinds)
    if (kind.of_positions || !of_points)
      largest = std::max(largest, (kind.before - kind.after) / kind.rows);
  return largest;
}

/// Largest share, over kinds of channels, of what is missed there beyond the noise.
double share_of_missed(const std::vector<KindChi2>& kinds) {
  double largest = 0.0;
  for (const KindChi2& kind : kinds)
    if (kind.before > kind.rows)
      largest = std::max(largest, (kind.before - kind.after) / (kind.before - kind.rows));
  return largest;
}

/// Where points are seen at all, they are met better.
bool moves_points(const std::vector<KindChi2>& kinds) {
  double gain = 0.0, rows = 0.0;
  for (const KindChi2& kind : kinds)
    if (kind.of_positions) {
      gain += kind.before - kind.after;
      rows += kind.rows;
    }
  return rows == 0.0 || gain > kDecisive;
}

/// Over all kinds, each in the noise that the larger model leaves of it where that is more than
/// what is stated: a hundred forces that scatter twice as far as stated would pass for strong
/// evidence beside ten thousand positions that do not.
KindChi2 in_noise_left(const std::vector<KindChi2>& kinds) {
  KindChi2 sum;
  for (const KindChi2& kind : kinds) {
    const double noise = std::max(1.0, kind.after / kind.rows);
    sum.before += kind.before / noise;
    sum.after += kind.after / noise;
    sum.rows += kind.rows;
  }
  return sum;
}

/// An accident's reading, beside the frame where it is said to be; the objection, or nothing.
std::string accident_objection(const FieldTrial& field, const FieldFit& before,
                               const FieldData& data) {
  const Trial& trial = field.trial;
  for (const model::SensorCorrection& c : trial.model.corrections) {
    const bool is_added =
        std::any_of(trial.variant.corrections.begin(), trial.variant.corrections.end(),
                    [&](const auto& added) { return added.id == c.id; });
    if (!is_added || c.type != "clip_slip") continue;
    Step step;
    std::vector<double> said_before, said_after;
    double left = 0.0;
    for (std::size_t r = 0; r < before.rows.size(); ++r) {
      const estimation::Row& row = before.rows[r];
      const estimation::Sequence& sequence = data.sequences[static_cast<std::size_t>(row.curve)];
      const int force = row.channel - 3 * static_cast<int>(sequence.points.size());
      if (sequence.name != c.capture || force < 0 ||
          force >= static_cast<int>(sequence.forces.size()) ||
          sequence.forces[static_cast<std::size_t>(force)].name != c.component)
        continue;
      const double was = before.at.fit.residuals[static_cast<Eigen::Index>(r)];
      const double is = trial.fit.residuals[static_cast<Eigen::Index>(r)];
      const bool is_early = row.frame < c.parameters[1].value;
      (is_early ? step.before : step.after).push_back(was);
      (is_early ? said_before : said_after).push_back(was - is);
      left += is * is;
    }
    const auto count = static_cast<double>(step.before.size() + step.after.size());
    // a reading scatters by what is stated or by what is left of it, if that is more
    step.sigma = std::sqrt(std::max(1.0, left / std::max(1.0, count)));
    step.size = jump_of(said_before, said_after);
    std::string objection = step_objection(step);
    if (!objection.empty()) return objection;
  }
  return "";
}

/// Expected square by which a fit to the rest errs on what is left out, tr(J_o (J_t'J_t)^-1 J_o')
/// in noises of the size that the fit leaves; infinite where the rest does not determine it.
double blur(const estimation::FitResult& fit, const Eigen::VectorXd& training) {
  std::vector<Eigen::Index> moving;
  for (std::size_t i = 0; i < fit.states.size(); ++i)
    if (fit.states[i] == estimation::ParameterState::free)
      moving.push_back(static_cast<Eigen::Index>(i));
  if (moving.empty()) return 0.0;
  Eigen::MatrixXd j = fit.jacobian(Eigen::indexing::all, moving);
  for (Eigen::Index c = 0; c < j.cols(); ++c) j.col(c) /= std::max(1e-300, j.col(c).norm());
  const Eigen::MatrixXd all = j.transpose() * j;
  const Eigen::MatrixXd rest = j.transpose() * training.asDiagonal() * j;
  const Eigen::LDLT<Eigen::MatrixXd> factor(
      rest + 1e-10 * Eigen::MatrixXd::Identity(rest.rows(), rest.cols()));
  const double noise = std::max(1.0, fit.chi2 / static_cast<double>(fit.residuals.size()));
  return noise * factor.solve(all - rest).trace();
}

estimation::HeldOut as_held_out(const FieldFit& fit) {
  estimation::HeldOut result;
  result.usable = fit.at.fit.usable;
  result.chi2 = fit.at.fit.chi2;
  result.residuals = fit.at.fit.residuals;
  result.left_out = Eigen::VectorXd::Ones(result.residuals.size());
  return result;
}

/// What the smaller model misses of what is left out, in channels of the kind, positions or all
/// else, that the trial is about: the noise of many positions may be off by more than forces miss.
/// `noise`: of a row.
double above_noise(std::size_t kind, const std::vector<estimation::Sequence>& sequences,
                   const std::vector<estimation::Row>& rows, const estimation::HeldOut& left_out,
                   double noise) {
  const Misfit missed =
      misfit_of(sequences, rows, left_out.residuals.cwiseProduct(left_out.left_out));
  const Misfit seen = misfit_of(sequences, rows, left_out.left_out);
  return std::max(0.0, missed.chi2[kind] - noise * seen.chi2[kind]);
}

/// 0 where a trial explains more of positions, else 1.
std::size_t kind_of_gain(const FieldTrial& trial, const FieldFit& before, const FieldData& data) {
  const auto chi2 = [&](const Eigen::VectorXd& residuals) {
    return misfit_of(data.sequences, before.rows, residuals).chi2;
  };
  const auto was = chi2(before.at.fit.residuals), is = chi2(trial.trial.fit.residuals);
  return was[0] - is[0] > was[1] - is[1] ? 0 : 1;
}

/// Captures that are held out and hang on what those that are fitted do not determine, a shear that
/// nobody saw, are missed by far more; what one more effect does there is chance.
bool is_out_of_reach(const FieldFit& held_out, const FieldFit& fitted) {
  constexpr double kFurther = 3.0;
  const auto by_row = [](const FieldFit& fit) {
    return fit.at.fit.chi2 / std::max(1.0, static_cast<double>(fit.rows.size()));
  };
  return by_row(held_out) > kFurther * by_row(fitted);
}

std::string held_out_objection(FieldTrial& trial, const FieldFit& before, const FieldData& data,
                               const HeldOutSheets& held_out, double expected_chi2,
                               const FieldFitOptions& options) {
  const std::size_t kind = kind_of_gain(trial, before, data);
  if (held_out.data != nullptr) {
    const auto after =
        predict_field(trial.trial.model, *held_out.data, held_out.before.states, options);
    if (after) {
      const estimation::HeldOut earlier = as_held_out(held_out.before), later = as_held_out(*after);
      std::string objection = compare_held_out(
          trial.trial, earlier, later, after->rows, held_out.data->block_count(), "captures",
          above_noise(kind, held_out.data->sequences, after->rows, earlier, 1.0));
      const bool speaks_against = !is_out_of_reach(held_out.before, before) &&
                                  later.chi2 - earlier.chi2 > trial.trial.held_out_error;
      if (objection.empty() || speaks_against) return objection;
    }
    // held-out captures that do not show an effect (a fault of one capture, a hold that they lack)
    // speak neither for nor against it: then parts of what was fitted judge, left out in turn
  }
  const FieldFit larger = fit_of(trial, before);
  estimation::Folds folds = telling_folds(larger, before, data);
  estimation::HeldOut after, earlier;
  // the others judge where a sheet comes to no rest without some part of the data
  for (bool is_done = folds.training.empty(); !is_done;) {
    after = cross_validate_field(larger, data, folds, options);
    earlier = after.usable ? cross_validate_field(before, data, folds, options) : after;
    const int failed = earlier.failed_fold;
    is_done = failed < 0 || folds.training.size() <= 2;
    if (!is_done) folds.training.erase(folds.training.begin() + failed);
  }
  // a fault of an instrument is the same in every frame: where no part can be left out, some can;
  // and so they may where captures that were held out to judge cannot
  const bool asks_frames =
      trial.trial.effect->kind == effects::Kind::sensor || held_out.data != nullptr;
  if ((!after.usable || !earlier.usable) && asks_frames) {
    folds = telling_folds(larger, before, data, {"frames"});
    if (!folds.training.empty()) {
      after = cross_validate_field(larger, data, folds, options);
      earlier = cross_validate_field(before, data, folds, options);
    }
  }
  if (folds.training.empty()) return kNothingLeftOut;
  const double noise = expected_chi2 / static_cast<double>(before.rows.size());
  return compare_held_out(
      trial.trial, earlier, after, before.rows, data.block_count(), folds.kind,
      earlier.usable ? above_noise(kind, data.sequences, before.rows, earlier, noise) : 0.0);
}

}  // namespace

estimation::Folds telling_folds(const FieldFit& larger, const FieldFit& smaller,
                                const FieldData& data, const std::vector<std::string>& kinds) {
  constexpr double kShown = 0.02;   // of the whole gain, by what is left out
  constexpr double kBlurred = 0.5;  // of the gain there, by what the rest does not know
  const Eigen::VectorXd gain =
      smaller.at.fit.residuals.cwiseAbs2() - larger.at.fit.residuals.cwiseAbs2();
  const double whole = gain.sum();
  for (const std::string& kind : kinds) {
    estimation::Folds folds = field_folds(data, larger.rows, kind);
    std::erase_if(folds.training, [&](const Eigen::VectorXd& training) {
      const Eigen::VectorXd left_out = Eigen::VectorXd::Ones(training.size()) - training;
      const double shown = gain.dot(left_out);
      return shown < kShown * whole || blur(larger.at.fit, training) > kBlurred * shown;
    });
    if (folds.training.size() >= 2) return folds;
  }
  return {};
}

FieldTrial refit_field(const Candidate& candidate, const FieldFit& base, const FieldData& data,
                       const FieldFitOptions& options) {
  const auto fitted_from = [&](const Setting& setting) {
    const model::Model start =
        extend(base.at.model, candidate.variant, setting, candidate.effect->id);
    auto fit = fit_field(start, data, base.states, options);
    return fit ? trial_of(std::move(*fit)) : FieldTrial{};
  };
  FieldTrial result = fitted_from(candidate.setting);
  if (!result.trial.fit.usable ||
      result.trial.fit.chi2 > base.at.fit.chi2 - 0.5 * candidate.within) {
    FieldTrial again = fitted_from(candidate.point);
    if (again.trial.fit.usable &&
        (!result.trial.fit.usable || again.trial.fit.chi2 < result.trial.fit.chi2))
      result = std::move(again);
  }
  result.trial.effect = candidate.effect;
  result.trial.variant = candidate.variant;
  result.trial.ratio = candidate.ratio;
  if (result.trial.fit.usable) result.trial.parameters = free_count(result.trial.model);
  return result;
}

std::string objection_by_kind(const std::array<double, 2>& taken, const Misfit& before,
                              const Misfit& after, bool is_more_of_one) {
  constexpr double kWorse = 0.15;     // of what is gained
  constexpr double kMuchWorse = 0.5;  // of what was missed of the others
  const auto gained = [&](std::size_t kind) { return before.chi2[kind] - after.chi2[kind]; };
  const std::size_t shown = gained(0) > gained(1) ? 0 : 1;
  if (!is_more_of_one && is_within_form(gained(shown), taken[shown], kFormOfSheets))
    return "it is no more than the form of what was found may miss";
  const double allowed = std::min(kWorse * gained(shown), kMuchWorse * before.chi2[1 - shown]);
  if (-gained(1 - shown) > std::max(kDecisive, allowed))
    return shown == 0 ? "what it explains of the positions it misses of the forces"
                      : "what it explains of the forces it misses of the positions";
  return "";
}

std::string objection_of_grid(const std::array<double, 2>& taken, const Misfit& before,
                              const Misfit& after, const Variant& variant) {
  const auto gained = [&](std::size_t kind) { return before.chi2[kind] - after.chi2[kind]; };
  const std::size_t shown = gained(0) > gained(1) ? 0 : 1;
  constexpr double kFormOfPatches = 0.6;  // that error lies at corners of clips, as a patch does
  const double form = has_many_places(variant) ? kFormOfPatches : kFormOfGrid;
  return is_within_form(gained(shown), taken[shown], form)
             ? "it is no more than the estimate of the grid's error may miss"
             : "";
}

void judge_field(FieldTrial& field, const FieldFit& before, const FieldData& data,
                 const HeldOutSheets& held_out, double expected_chi2,
                 const FieldFitOptions& options) {
  Trial& trial = field.trial;
  if (!trial.fit.usable) {
    trial.objections.push_back("the refit failed: " + trial.fit.message);
    return;
  }
  const estimation::FitResult& earlier = before.at.fit;
  const double rows = std::max(trial.fit.effective_rows, earlier.effective_rows);
  const int added = std::max(1, trial.parameters - free_count(before.at.model));
  const std::vector<KindChi2> kinds = chi2_by_kind(before, field, data);
  const KindChi2 all = in_noise_left(kinds);
  trial.p_value = std::min(1.0, trial.variant.searched * f_test(all.before, all.after, added,
                                                                determined_count(trial.fit), rows));
  trial.explained = explained_share(earlier.chi2, trial.fit.chi2, expected_chi2);
  constexpr double kSmallest = 0.05;  // of the noise's power: what is smaller matters to nobody
  if (share_of_noise(kinds, is_of_points(trial.variant)) < kSmallest)
    trial.objections.push_back("what it explains is far below the noise");
  if (trial.p_value >= 1e-3)
    trial.objections.push_back("an F test on independent rows gives it p = " +
                               std::to_string(trial.p_value));
  constexpr double kLeastOfMany = 0.35;  // less is a stand-in's
  if (has_many_places(trial.variant) && share_of_missed(kinds) < kLeastOfMany)
    trial.objections.push_back("so many numbers explain little of what is missed");
  if (has_many_places(trial.variant) && !moves_points(kinds))
    trial.objections.push_back("points, which it would move, show nothing of it");
  check_parameters(trial);
  if (!trial.effect->in_every_run) {
    const std::string objection = accident_objection(field, before, data);
    if (!objection.empty()) trial.objections.push_back(objection);
  }
  if (!trial.objections.empty()) return;
  const std::string objection =
      held_out_objection(field, before, data, held_out, expected_chi2, options);
  if (!objection.empty()) trial.objections.push_back(objection);
}

}  // namespace tenter::diagnosis
