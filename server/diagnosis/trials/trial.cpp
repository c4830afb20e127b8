// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/trial.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "common/model/catalogue.h"
#include "server/diagnosis/trials/at_rest.h"

namespace tenter::diagnosis {

using estimation::ParameterState;

int free_count(const model::Model& model) {
  int count = 0;
  for (const model::Parameter* p : estimation::parameters_of(model)) count += p->fixed ? 0 : 1;
  return count;
}

int determined_count(const estimation::FitResult& fit) {
  return static_cast<int>(std::ranges::count(fit.states, ParameterState::free));
}

std::vector<double> chi2_by_block(const std::vector<estimation::Row>& rows,
                                  const Eigen::VectorXd& residuals, int blocks) {
  std::vector<double> sums(static_cast<std::size_t>(blocks), 0.0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double x = residuals[static_cast<Eigen::Index>(r)];
    if (!std::isfinite(x)) continue;  // no fold left this row out
    sums[static_cast<std::size_t>(rows[r].block)] += x * x;
  }
  return sums;
}

double f_test(double chi2_before, double chi2_after, int added, int parameters, double rows) {
  const double freedom = rows - parameters;
  if (added <= 0 || freedom < 1.0 || chi2_after >= chi2_before) return 1.0;
  if (chi2_after <= 0.0) return 0.0;
  const double f = (chi2_before - chi2_after) / added / (chi2_after / freedom);
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(added, freedom), f));
}

double information(double chi2, int parameters, int added_effects, double rows) {
  return rows * std::log(std::max(chi2, 1e-12) / rows) + parameters * std::log(rows) +
         2.0 * added_effects * std::log(static_cast<double>(catalogue().size()));
}

Trial refit(const Candidate& candidate, const Reference& base, const DataPointer& data) {
  Trial trial;
  trial.effect = candidate.effect;
  trial.variant = candidate.variant;
  trial.ratio = candidate.ratio;
  trial.data = data;
  trial.model = extend(base.model, candidate.variant, candidate.setting, candidate.effect->id);
  estimation::adapt_spline_ranges(trial.model, data->curves);
  auto evaluator = estimation::Evaluator::make(trial.model, data);
  if (!evaluator) return trial;
  estimation::FitOptions options;
  options.max_iterations = 60;
  options.tolerance = 1e-6;
  trial.fit = estimation::fit(*evaluator, trial.model, options);
  // where the expected amplitudes led too far (a free direction bends the way there), once more
  // from "off"
  if (!trial.fit.usable || trial.fit.chi2 > base.fit.chi2 - 0.5 * candidate.within) {
    model::Model off = extend(base.model, candidate.variant, candidate.point, candidate.effect->id);
    estimation::adapt_spline_ranges(off, data->curves);
    estimation::FitResult again = estimation::fit(*evaluator, off, options);
    if (again.usable && (!trial.fit.usable || again.chi2 < trial.fit.chi2)) {
      trial.fit = std::move(again);
      trial.model = std::move(off);
    }
  }
  if (!trial.fit.usable) return trial;
  estimation::store(trial.fit, trial.model);
  trial.parameters = free_count(trial.model);
  trial.block_chi2 = chi2_by_block(evaluator->rows(), trial.fit.residuals, data->block_count());
  return trial;
}

namespace {

bool enters_nonlinearly(const std::string& name) {
  for (const char* ending : {".tau", ".relaxation_time", ".strain_scale", ".yield_strain",
                             ".at_frame", ".cap", ".limit"})
    if (name.ends_with(ending)) return true;
  return false;
}

/// Relative standard error of several amplitudes together at the given shape, 1/sqrt(a' C^-1 a)
/// with C their covariance when the parameters of the shape (tau and the like) are held: parameters
/// that trade against each other may each be vague while what they do together is not. Infinite
/// where none moves.
double joint_relative_error(const Trial& trial, const std::vector<std::size_t>& amplitudes,
                            const std::vector<double>& off, const std::vector<std::size_t>& shape) {
  const auto is_free = [&](std::size_t i) { return trial.fit.states[i] == ParameterState::free; };
  std::vector<std::size_t> moving;
  std::vector<double> value;
  for (std::size_t i = 0; i < amplitudes.size(); ++i) {
    if (!is_free(amplitudes[i])) continue;
    moving.push_back(amplitudes[i]);
    value.push_back(trial.fit.parameters[static_cast<Eigen::Index>(amplitudes[i])] - off[i]);
  }
  if (moving.empty()) return 1e300;
  const auto n = static_cast<Eigen::Index>(moving.size());
  for (const std::size_t i : shape)
    if (is_free(i)) moving.push_back(i);
  const auto all = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd covariance(all, all);
  for (Eigen::Index r = 0; r < all; ++r) {
    const auto i = static_cast<Eigen::Index>(moving[static_cast<std::size_t>(r)]);
    for (Eigen::Index c = 0; c < all; ++c) {
      const auto j = static_cast<Eigen::Index>(moving[static_cast<std::size_t>(c)]);
      covariance(r, c) =
          trial.fit.correlation(i, j) * trial.fit.std_error[i] * trial.fit.std_error[j];
    }
  }
  // the information of the amplitudes at a fixed shape is the block of the whole information
  const Eigen::MatrixXd information =
      covariance.ldlt().solve(Eigen::MatrixXd::Identity(all, all)).topLeftCorner(n, n);
  const Eigen::Map<const Eigen::VectorXd> a(value.data(), n);
  const double wald = a.dot(information * a);
  return wald > 0.0 ? 1.0 / std::sqrt(wald) : 1e300;
}

/// An effect whose own parameters are all at their bounds or within their errors of nothing is
/// another one that happens to be written with the same law.
void check_hallmarks(const std::vector<std::string>& names, Trial& trial) {
  const std::vector<std::string>& endings = trial.effect->hallmarks;
  if (endings.empty() || trial.variant.append.empty()) return;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool is_own = std::ranges::any_of(trial.variant.append, [&](const model::Term& term) {
      return names[i].starts_with(term.id + ".");
    });
    const bool is_hallmark = std::ranges::any_of(
        endings, [&](const std::string& ending) { return names[i].ends_with(ending); });
    if (is_own && is_hallmark && is_surely_there(trial.fit, i)) return;
  }
  std::string all;
  for (const std::string& ending : endings) all += (all.empty() ? "" : ", ") + ending.substr(1);
  trial.objections.push_back("what is its own (" + all + ") is not surely there");
}

}  // namespace

bool is_surely_there(const estimation::FitResult& fit, std::size_t parameter) {
  constexpr double kSurely = 2.0;  // standard errors
  const auto k = static_cast<Eigen::Index>(parameter);
  return fit.states[parameter] == ParameterState::free &&
         std::abs(fit.parameters[k]) > kSurely * fit.std_error[k];
}

void check_parameters(Trial& trial) {
  constexpr double kVague = 0.5;
  const auto names = estimation::parameter_names(trial.model);
  const auto all = estimation::parameters_of(std::as_const(trial.model));
  // amplitudes of those who are one addition, each with its value when off
  const auto check = [&](const std::vector<std::pair<std::string, double>>& owners) {
    std::vector<std::size_t> amplitudes;
    std::vector<std::size_t> shape;
    std::vector<double> off;
    for (const auto& [owner, off_value] : owners)
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (!names[i].starts_with(owner + ".") || all[i]->fixed) continue;
        if (!enters_nonlinearly(names[i])) {
          amplitudes.push_back(i);
          off.push_back(off_value);
          continue;
        }
        shape.push_back(i);
        if (all[i]->upper && all[i]->value >= *all[i]->upper * (1.0 - 1e-6))
          trial.objections.push_back(names[i] + " runs to its upper bound");
      }
    const double error = joint_relative_error(trial, amplitudes, off, shape);
    const std::string& first = owners.front().first;
    if (error > 1e3)
      trial.objections.push_back(first + " is at a bound or moves nothing");
    else if (error > kVague)
      trial.objections.push_back("the size of " + first + " is known to no better than " +
                                 std::to_string(static_cast<int>(std::min(error * 100.0, 999.0))) +
                                 " %");
  };
  std::vector<std::pair<std::string, double>> terms;
  for (const model::Term& term : trial.variant.append) {
    terms.emplace_back(term.id, 0.0);
    if (!trial.variant.parts_are_one) check({terms.back()});
    // parts of one take the place of what is alike everywhere, from its value on
    terms.back().second = term.law.parameters.front().value;
  }
  if (trial.variant.parts_are_one && !terms.empty()) check(terms);
  check_hallmarks(names, trial);
  std::vector<std::pair<std::string, double>> corrections;
  for (const model::SensorCorrection& c : trial.variant.corrections) {
    const model::CorrectionRow* row = nullptr;  // of curves or of sheets
    for (const model::Seen seen : {model::Seen::curves, model::Seen::sheets})
      if (row == nullptr) row = model::find_correction(c.type, seen);
    corrections.emplace_back(c.id, row->parameters.front().value);
    if (!trial.variant.parts_are_one) check({corrections.back()});
  }
  if (trial.variant.parts_are_one && !corrections.empty()) check(corrections);
}

double jump_of(const std::vector<double>& before, const std::vector<double>& after) {
  constexpr std::size_t kFrames = 5;
  // medians: one misread sample beside the place is no step
  const auto middle = [](std::vector<double> x) {
    std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
    return x[x.size() / 2];
  };
  if (before.empty() || after.empty()) return 0.0;
  const auto early = static_cast<std::ptrdiff_t>(std::min(kFrames, before.size()));
  const auto late = static_cast<std::ptrdiff_t>(std::min(kFrames, after.size()));
  return middle({after.begin(), after.begin() + late}) -
         middle({before.end() - early, before.end()});
}

std::string step_objection(const Step& step) {
  constexpr std::size_t kFewest = 3;
  constexpr double kSigmas = 2.5;
  if (step.before.size() < kFewest || step.after.size() < kFewest)
    return "the step is at the end of a run";
  const double jump = jump_of(step.before, step.after);
  if (!(jump * step.size > 0.0) || std::abs(jump) < 0.5 * std::abs(step.size) ||
      std::abs(jump) < kSigmas * step.sigma)
    return "the residuals do not jump where the step should be";
  return "";
}

namespace {

/// The residuals of an accident in a curve, in stresses, beside the frame where it is said to be.
void check_step(Trial& trial, const Reference& before, const std::vector<estimation::Row>& rows) {
  for (const model::SensorCorrection& c : trial.variant.corrections) {
    const model::SensorCorrection* fitted = nullptr;
    for (const model::SensorCorrection& f : trial.model.corrections)
      if (f.id == c.id) fitted = &f;
    if (!fitted || c.type != "clip_slip") continue;
    const int at = static_cast<int>(fitted->parameters[1].value);
    Step step;
    step.size = fitted->parameters[0].value;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto& curves = trial.data->curves[static_cast<std::size_t>(rows[r].curve)];
      const auto& channel = curves.channels[static_cast<std::size_t>(rows[r].channel)];
      if (curves.id != c.capture || !channel.is_stress ||
          estimation::component_name(channel.component) != c.component)
        continue;
      step.sigma = trial.data->sigma_of(rows[r]);
      const double x = -before.fit.residuals[static_cast<Eigen::Index>(r)] * step.sigma;
      const int origin = curves.origin[static_cast<std::size_t>(rows[r].frame)];
      (origin < at ? step.before : step.after).push_back(x);
    }
    const std::string objection = step_objection(step);
    if (!objection.empty()) trial.objections.push_back(objection);
  }
}

}  // namespace

std::string compare_held_out(Trial& trial, const estimation::HeldOut& earlier,
                             const estimation::HeldOut& after,
                             const std::vector<estimation::Row>& rows, int blocks,
                             const std::string& kind, double above_noise) {
  if (!after.usable || !earlier.usable) return "a refit without one of the " + kind + " failed";
  trial.folds = kind;
  trial.held_out_before = earlier.chi2;
  trial.held_out_after = after.chi2;
  trial.held_out_residuals = after.residuals;
  const auto a = chi2_by_block(rows, after.residuals, blocks);
  const auto b = chi2_by_block(rows, earlier.residuals, blocks);
  double mean = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) mean += (b[i] - a[i]) / static_cast<double>(a.size());
  double variance = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    variance += std::pow(b[i] - a[i] - mean, 2) /
                static_cast<double>(std::max<std::size_t>(1, a.size() - 1));
  trial.held_out_error = std::sqrt(variance * static_cast<double>(a.size()));
  const double gain = earlier.chi2 - after.chi2;
  if (gain < trial.held_out_error)
    return "on left-out " + kind + " the gain is within its own standard error";
  if (gain < 0.05 * above_noise)
    return "on left-out " + kind + " it gains less than 5 % of what is above the noise";
  return "";
}

namespace {

/// One comparison on left-out data; the objection to the trial, or nothing.
std::string held_out_objection(Trial& trial, const Reference& before, const DataPointer& data,
                               double expected_chi2, const estimation::Folds& folds,
                               estimation::Evaluator& larger, estimation::Evaluator& smaller) {
  estimation::FitOptions options;
  options.max_iterations = 25;
  options.tolerance = 1e-5;
  const estimation::HeldOut after = estimation::cross_validate(larger, trial.model, folds, options);
  const estimation::HeldOut earlier =
      estimation::cross_validate(smaller, before.model, folds, options);
  const double share = earlier.left_out.sum() / static_cast<double>(earlier.left_out.size());
  return compare_held_out(trial, earlier, after, larger.rows(), data->block_count(), folds.kind,
                          std::max(0.0, earlier.chi2 - expected_chi2 * share));
}

/// The hardest kind of left-out data that can judge the trial counts: at least two folds of it in
/// which the rest of the data determine what the effect does to what is left out. A protocol that
/// alone shows an effect cannot be foretold without it, and its fold says nothing.
void check_held_out(Trial& trial, const Reference& before, const DataPointer& data,
                    double expected_chi2) {
  auto larger = estimation::Evaluator::make(trial.model, data);
  auto smaller = estimation::Evaluator::make(before.model, data);
  std::string objection = kNothingLeftOut;
  for (const std::string& kind : estimation::fold_kinds()) {
    estimation::Folds folds = estimation::make_folds(*data, larger->rows(), kind);
    estimation::keep_determined(folds, trial.fit,
                                estimation::added_parameters(trial.model, before.model));
    if (folds.training.size() < 2) continue;
    objection = held_out_objection(trial, before, data, expected_chi2, folds, *larger, *smaller);
    break;
  }
  if (objection.empty()) return;
  trial.objections.push_back(objection);
}

}  // namespace

bool lacks_only_proof(const Trial& trial) {
  return trial.objections.size() == 1 && trial.objections.front() == kNothingLeftOut;
}

Reference reference_of(const Trial& trial) {
  return {trial.model, trial.fit, trial.block_chi2};
}

double criterion_of(const Trial& trial, int added_effects, double rows) {
  const double asked = trial.effect->special_form_of.empty() ? 0.0 : kDecisive;
  return information(trial.fit.chi2, trial.parameters, added_effects, rows) + asked;
}

bool is_within_form(double gain, double taken, double form) {
  return gain < form * form * taken;  // chi2 is the square of a size
}

double explained_share(double before, double after, double expected_chi2) {
  const double missed = before - expected_chi2;
  return missed > 0.0 ? std::min(1.0, (before - after) / missed) : 1.0;
}

void judge(Trial& trial, const Reference& before, const DataPointer& data, double expected_chi2) {
  if (!trial.fit.usable) {
    trial.objections.push_back("the refit failed: " + trial.fit.message);
    return;
  }
  const double rows = std::max(trial.fit.effective_rows, before.fit.effective_rows);
  const int added = std::max(1, trial.parameters - free_count(before.model));
  trial.p_value =
      std::min(1.0, trial.variant.searched * f_test(before.fit.chi2, trial.fit.chi2, added,
                                                    determined_count(trial.fit), rows));
  trial.explained = explained_share(before.fit.chi2, trial.fit.chi2, expected_chi2);
  constexpr double kSmallest = 0.05;  // of the noise's power: what is smaller matters to nobody
  if (before.fit.chi2 - trial.fit.chi2 < kSmallest * expected_chi2)
    trial.objections.push_back("what it explains is far below the noise");
  if (trial.p_value >= 1e-3)
    trial.objections.push_back("an F test on independent rows gives it p = " +
                               std::to_string(trial.p_value));
  check_parameters(trial);
  if (std::string why = objection_at_rest(trial, data); !why.empty())
    trial.objections.push_back(std::move(why));
  if (!trial.effect->in_every_run) check_step(trial, before, data->rows());
  if (!trial.effect->in_every_run || !trial.objections.empty()) return;

  check_held_out(trial, before, data, expected_chi2);
}

}  // namespace tenter::diagnosis
