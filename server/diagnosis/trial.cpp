// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trial.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

namespace tenter::diagnosis {

using estimation::ParameterState;

int free_count(const model::Model& model) {
  int count = 0;
  for (const model::Parameter* p : estimation::parameters_of(model)) count += p->fixed ? 0 : 1;
  return count;
}

std::vector<double> chi2_by_block(const std::vector<estimation::Row>& rows, const Eigen::VectorXd& residuals,
                                  int blocks) {
  std::vector<double> sums(static_cast<std::size_t>(blocks), 0.0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double x = residuals[static_cast<Eigen::Index>(r)];
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

Trial refit(const Candidate& candidate, const model::Model& base, const DataPointer& data) {
  Trial trial;
  trial.effect = candidate.effect;
  trial.variant = candidate.variant;
  trial.ratio = candidate.ratio;
  trial.model = extend(base, candidate.variant, candidate.setting, candidate.effect->id);
  estimation::adapt_spline_ranges(trial.model, data->curves);
  auto evaluator = estimation::Evaluator::make(trial.model, data);
  if (!evaluator) return trial;
  trial.fit = estimation::fit(*evaluator, trial.model, {});
  if (!trial.fit.usable) {  // the expected amplitudes may be too far: once more from "off"
    Setting grid_only;
    for (const auto& [address, value] : candidate.setting)
      for (const Setting& point : candidate.variant.grid)
        for (const auto& entry : point)
          if (entry.first == address && entry.second == value) grid_only.emplace_back(address, value);
    trial.model = extend(base, candidate.variant, grid_only, candidate.effect->id);
    estimation::adapt_spline_ranges(trial.model, data->curves);
    trial.fit = estimation::fit(*evaluator, trial.model, {});
  }
  if (!trial.fit.usable) return trial;
  estimation::store(trial.fit, trial.model);
  trial.parameters = free_count(trial.model);
  trial.block_chi2 = chi2_by_block(evaluator->rows(), trial.fit.residuals, data->block_count());
  return trial;
}

namespace {

/// Amplitudes of the terms that the variant added: is each alive and known to better than a half?
void check_parameters(Trial& trial) {
  const auto names = estimation::parameter_names(trial.model);
  const auto all = estimation::parameters_of(std::as_const(trial.model));
  const auto of_owner = [&](const std::string& owner, auto&& visit) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i].starts_with(owner + ".")) visit(i);
  };
  for (const model::Term& term : trial.variant.append) {
    double best = 1e300;
    bool alive = false;
    of_owner(term.id, [&](std::size_t i) {
      const auto k = static_cast<Eigen::Index>(i);
      const bool nonlinear = names[i].ends_with(".tau") || names[i].ends_with(".relaxation_time") ||
                             names[i].ends_with(".strain_scale") || names[i].ends_with(".yield_strain");
      if (all[i]->fixed) return;
      if (nonlinear) {
        const bool at_upper = all[i]->upper && all[i]->value >= *all[i]->upper * (1.0 - 1e-6);
        if (at_upper) trial.objections.push_back(names[i] + " runs to its upper bound");
        return;
      }
      if (trial.fit.states[i] == ParameterState::free) {
        alive = true;
        best = std::min(best, trial.fit.std_error[k] / std::abs(all[i]->value));
      }
    });
    if (!alive)
      trial.objections.push_back("the term " + term.id + " is at a bound or moves nothing");
    else if (best > 0.5)
      trial.objections.push_back("the size of " + term.id + " is known to no better than " +
                                 std::to_string(static_cast<int>(std::min(best * 100.0, 999.0))) + " %");
  }
  for (const model::SensorCorrection& correction : trial.variant.corrections) {
    of_owner(correction.id, [&](std::size_t i) {
      if (all[i]->fixed) return;
      const auto k = static_cast<Eigen::Index>(i);
      const double off = names[i].ends_with("value") && correction.type == "gain" ? 1.0 : 0.0;
      if (trial.fit.states[i] != ParameterState::free ||
          trial.fit.std_error[k] > 0.5 * std::abs(all[i]->value - off))
        trial.objections.push_back("the size of " + correction.id + " is not known to within a half");
    });
  }
}

}  // namespace

void judge(Trial& trial, const Reference& before, const DataPointer& data, double expected_chi2) {
  if (!trial.fit.usable) {
    trial.objections.push_back("the refit failed: " + trial.fit.message);
    return;
  }
  const double rows = std::max(trial.fit.effective_rows, before.fit.effective_rows);
  const int added = std::max(1, trial.parameters - free_count(before.model));
  trial.p_value = f_test(before.fit.chi2, trial.fit.chi2, added, trial.parameters, rows);
  if (trial.p_value >= 1e-3) trial.objections.push_back("an F test on independent rows gives it p = " + std::to_string(trial.p_value));
  check_parameters(trial);
  if (!trial.effect->in_every_run || !trial.objections.empty()) return;

  auto larger = estimation::Evaluator::make(trial.model, data);
  auto smaller = estimation::Evaluator::make(before.model, data);
  const estimation::Folds folds = estimation::make_folds(*data, larger->rows(), trial.fit);
  trial.folds = folds.kind;
  if (folds.training.empty()) return;
  estimation::FitOptions options;
  options.max_iterations = 25;
  const estimation::HeldOut after = estimation::cross_validate(*larger, trial.model, folds, options);
  const estimation::HeldOut earlier = estimation::cross_validate(*smaller, before.model, folds, options);
  if (!after.usable || !earlier.usable) {
    trial.objections.push_back("a refit without one of the " + folds.kind + " failed");
    return;
  }
  trial.held_out_before = earlier.chi2;
  trial.held_out_after = after.chi2;
  const auto a = chi2_by_block(larger->rows(), after.residuals, data->block_count());
  const auto b = chi2_by_block(larger->rows(), earlier.residuals, data->block_count());
  double mean = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) mean += (b[i] - a[i]) / static_cast<double>(a.size());
  double variance = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    variance += std::pow(b[i] - a[i] - mean, 2) / static_cast<double>(std::max<std::size_t>(1, a.size() - 1));
  trial.held_out_error = std::sqrt(variance * static_cast<double>(a.size()));
  const double gain = earlier.chi2 - after.chi2;
  const double above_noise = std::max(0.0, earlier.chi2 - expected_chi2);
  if (gain < trial.held_out_error)
    trial.objections.push_back("on left-out " + folds.kind + " the gain is within its own standard error");
  else if (gain < 0.05 * above_noise)
    trial.objections.push_back("on left-out " + folds.kind + " it gains less than 5 % of what is above the noise");
}

}  // namespace tenter::diagnosis
