// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/uncertainty/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/estimation/least_squares/objective.h"
#include "server/estimation/parallel.h"

namespace tenter::estimation {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// What the fit made small: with its weights and its loss.
double cost_of(const Eigen::VectorXd& residuals, const Eigen::VectorXd& rows_weights,
               const FitOptions& options) {
  double cost = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    double weight = options.weights.size() > 0 ? options.weights[i] : 1.0;
    if (rows_weights.size() > 0) weight *= rows_weights[i];
    cost += weight * loss_at(options.loss, residuals[i] * residuals[i]).rho;
  }
  return cost;
}

/// Refits of one parameter's profile.
class Walker {
 public:
  Walker(ResidualFunction& evaluator, const model::Model& model, const FitResult& found,
         const FitOptions& options, const ProfileOptions& profile_options, int parameter)
      : evaluator_(evaluator),
        model_(model),
        options_(options),
        profile_options_(profile_options),
        width_(inflation(found, options)),
        at_(static_cast<std::size_t>(parameter)),
        best_(found.parameters[parameter]) {
    options_.on_iteration = nullptr;
    best_cost_ = cost_of(found.residuals, evaluator.weights(), options);
    start_ = found.parameters;
    profile_.parameter = parameter;
    const model::Parameter& p = *parameters_of(model_)[at_];
    lower_ = p.lower.value_or(-kNone);
    upper_ = p.upper.value_or(kNone);
    const double error = found.std_error[parameter];
    const double size = std::max(std::abs(best_), 1e-6);
    // at a bound, or where the covariance knows nothing, a small share of the value
    step_ = error > 0.0 && error < 10.0 * size ? error : 0.1 * size;
    reach_ = std::max(profile_options.reach * size, std::min(100.0 * error, 1e3 * size));
  }

  Profile run() {
    profile_.points = {{best_, 0.0}};
    profile_.hi = side(+1.0);
    profile_.lo = side(-1.0);
    std::sort(profile_.points.begin(), profile_.points.end(),
              [](const ProfilePoint& a, const ProfilePoint& b) { return a.value < b.value; });
    profile_.determined = judge();
    return std::move(profile_);
  }

 private:
  /// Rise of the cost with the parameter at a value, others refitted from where they are; let go,
  /// it only starts there.
  double rise_at(double value, Eigen::VectorXd& others, bool lets_go = false) {
    const auto parameters = parameters_of(model_);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      parameters[i]->value = others[static_cast<Eigen::Index>(i)];
    parameters[at_]->value = value;
    const bool was_fixed = parameters[at_]->fixed;
    parameters[at_]->fixed = !lets_go;
    const FitResult result = fit(evaluator_, model_, options_);
    parameters[at_]->fixed = was_fixed;
    ++profile_.fits;
    if (!result.usable) {
      ++profile_.failed;
      return kNone;
    }
    others = result.parameters;
    const double rise =
        (cost_of(result.residuals, evaluator_.weights(), options_) - best_cost_) / width_;
    profile_.points.push_back({result.parameters[static_cast<Eigen::Index>(at_)], rise});
    return rise;
  }

  double clamped(double value) const { return std::clamp(value, lower_, upper_); }

  /// The end of the interval on one side, then a look beyond it.
  std::optional<double> side(double direction) {
    Eigen::VectorXd others = start_;
    double inside = best_, inside_rise = 0.0;
    double outside = best_;
    double outside_rise = 0.0;
    double step = step_;
    const double end = clamped(best_ + direction * reach_);
    while (outside_rise < profile_options_.rise && outside != end) {
      inside = outside;
      inside_rise = outside_rise;
      const double next = inside + direction * step;
      outside = direction * (end - next) > 0.0 ? next : end;
      const Eigen::VectorXd before = others;
      outside_rise = rise_at(outside, others);
      if (outside_rise == kNone) {  // no answer there: as far as it goes
        others = before;
        break;
      }
      step *= 2.0;
    }
    if (!(outside_rise >= profile_options_.rise) || outside_rise == kNone) return std::nullopt;
    const double crossed = crossing(others, inside, inside_rise, outside, outside_rise);
    scan(direction, outside, end, others);
    return crossed;
  }

  // sqrt(rise) of a parabola is a straight line: regula falsi on it, kept between its ends
  double crossing(Eigen::VectorXd others, double inside, double inside_rise, double outside,
                  double outside_rise) {
    const double wanted = std::sqrt(profile_options_.rise);
    double low = std::sqrt(std::max(inside_rise, 0.0));
    double high = std::sqrt(outside_rise);
    double at = outside;
    constexpr int kSteps = 12;
    for (int i = 0; i < kSteps; ++i) {
      const double share = std::clamp((wanted - low) / (high - low), 0.05, 0.95);
      at = inside + share * (outside - inside);
      const double rise = rise_at(at, others);
      if (rise == kNone) break;
      const double root = std::sqrt(std::max(rise, 0.0));
      if (std::abs(root - wanted) < 1e-3 * wanted) break;
      (root < wanted ? inside : outside) = at;
      (root < wanted ? low : high) = root;
    }
    return at;
  }

  // a basin may be too narrow for a few points to meet: from each, a fit that is let go finds it
  void scan(double direction, double from, double end, Eigen::VectorXd others) {
    for (int i = 1; i <= profile_options_.scan && direction * (end - from) > 0.0; ++i) {
      // denser near the interval: basins next to it are the likelier ones
      const double share = std::pow(static_cast<double>(i) / profile_options_.scan, 2.0);
      const double value = from + share * (end - from);
      if (rise_at(value, others) == kNone) return;
      Eigen::VectorXd let_go = others;
      rise_at(value, let_go, true);
    }
  }

  Determined judge() {
    const double slack = 0.02 * profile_options_.rise;
    double least = 0.0;
    bool falls_again = false;
    const auto look = [&](auto begin, auto stop) {
      double highest = 0.0;
      for (auto point = begin; point != stop; ++point) {
        least = std::min(least, point->rise);
        // a rise worth the name, then a fall to what cannot be told from the fit
        falls_again = falls_again || (highest > profile_options_.rise &&
                                      point->rise < profile_options_.rise - slack);
        highest = std::max(highest, point->rise);
      }
    };
    const auto best = std::find_if(profile_.points.begin(), profile_.points.end(),
                                   [&](const ProfilePoint& p) { return p.value >= best_; });
    look(best, profile_.points.end());
    look(std::make_reverse_iterator(best), profile_.points.rend());
    profile_.found_better = least < -slack;
    if (falls_again || profile_.found_better) return Determined::multimodal;
    if (profile_.lo && profile_.hi) return Determined::bounded;
    return profile_.lo || profile_.hi ? Determined::one_sided : Determined::flat;
  }

  ResidualFunction& evaluator_;
  model::Model model_;
  FitOptions options_;
  const ProfileOptions& profile_options_;
  double width_;
  std::size_t at_;
  double best_;
  double best_cost_ = 0.0;
  double lower_ = -kNone, upper_ = kNone;
  double step_ = 0.0, reach_ = 0.0;
  Eigen::VectorXd start_;
  Profile profile_;
};

}  // namespace

std::string_view words_of(Determined determined) {
  switch (determined) {
    case Determined::bounded:
      return "bounded";
    case Determined::one_sided:
      return "one_sided";
    case Determined::flat:
      return "flat";
    case Determined::multimodal:
      return "multimodal";
  }
  return "";
}

double inflation(const FitResult& found, const FitOptions& options) {
  double used = static_cast<double>(found.residuals.size());
  if (options.weights.size() > 0) used = (options.weights.array() > 0.0).cast<double>().sum();
  const auto free = static_cast<double>(
      std::count(found.states.begin(), found.states.end(), ParameterState::free));
  const double noise = std::max(1.0, found.chi2 / std::max(1.0, used));
  return std::max(1.0, noise * used / std::max(1.0, found.effective_rows - free));
}

std::vector<Profile> profiles(const MakeFunction& make, const model::Model& model,
                              const FitResult& found, const FitOptions& options,
                              const ProfileOptions& profile_options) {
  std::vector<int> wanted = profile_options.parameters;
  const auto parameters = parameters_of(model);
  if (wanted.empty())
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (!parameters[i]->fixed) wanted.push_back(static_cast<int>(i));
  std::vector<Profile> result(wanted.size());
  in_parallel(profile_options.threads, static_cast<int>(wanted.size()), [&](int, int k) {
    Profile& profile = result[static_cast<std::size_t>(k)];
    profile.parameter = wanted[static_cast<std::size_t>(k)];
    const auto evaluator = make();
    if (evaluator)
      profile = Walker(*evaluator, model, found, options, profile_options, profile.parameter).run();
  });
  return result;
}

}  // namespace tenter::estimation
