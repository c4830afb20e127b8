// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/limits/limit_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "server/estimation/least_squares/covariance.h"
#include "server/estimation/least_squares/objective.h"
#include "server/estimation/limits/limit_change.h"
#include "server/estimation/limits/resting_starts.h"
#include "server/estimation/uncertainty/profile.h"

namespace tenter::estimation {
namespace {

constexpr double kRise = 3.841458820694124;  // 95 % of chi-squared with one degree of freedom
constexpr double kUnlimited = 1e6;           // times the model's own Psi_max: never reached
constexpr double kStarts[] = {0.8,  0.6,  0.4,
                              0.25, 0.15, 0.08};  // of the largest density without the limit

constexpr int kForStart = 4;  // iterations that tell starts apart
constexpr int kAll = 1000000;

/// A value of Psi_max and what was fitted with it held.
struct Point {
  double energy_max = 0.0;
  double cost = std::numeric_limits<double>::infinity();
  std::unique_ptr<SequenceEvaluator> evaluator;
  FitResult fit;
};

/// Which way the cost falls with Psi_max, p following.
struct Descent {
  double step = 0.0;
  double std_error = 0.0;  ///< with unit errors of the rows
  Eigen::VectorXd follow;  ///< dp/dPsi_max
  LimitChange change;
};

class LimitSearch {
 public:
  LimitSearch(model::Model model, const std::vector<Sequence>& sequences, std::size_t limit,
              const LimitFitOptions& options)
      : model_(std::move(model)), sequences_(sequences), limit_(limit), options_(options) {}

  Expected<LimitFit> run() {
    const double given = model_.limits[limit_].energy_max;
    auto without = fitted(kUnlimited * given, parameter_values(model_));
    if (!without) return tl::unexpected(without.error());
    if (!without->fit.usable) return fail(ErrorKind::refused, without->fit.message);
    result_.cost_without = without->cost;
    if (without->fit.stopped) return stopped_at(*without);
    const auto reached = change_at(*without);
    if (!reached) return tl::unexpected(reached.error());
    if (reached->active_frames > 0)
      return bad_input("limit \"" + id() + "\": its energy_max lies too far below the data");
    auto best = best_start(given, reached->largest, without->fit.parameters);
    if (!best) return tl::unexpected(best.error());
    if (result_.stopped) return stopped_at(*best);
    if (best->fit.usable) {
      if (auto ok = alternate(*best); !ok) return tl::unexpected(ok.error());
      if (result_.stopped) return stopped_at(*best);
      const double width = inflation(best->fit, options_.fit);
      if (without->cost - best->cost > kRise * width) return determined(*best);
    }
    return never_reached(*without, reached->largest);
  }

 private:
  const std::string& id() const { return model_.limits[limit_].id; }

  model::Model model_at(double energy_max, const Eigen::VectorXd& parameters) const {
    model::Model model = model_;
    model.limits[limit_].energy_max = energy_max;
    const auto all = parameters_of(model);
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i]->value = parameters[static_cast<Eigen::Index>(i)];
    return model;
  }

  Eigen::VectorXd weights(const SequenceEvaluator& evaluator) const {
    Eigen::VectorXd all = evaluator.weights();
    if (all.size() == 0) all.setOnes(evaluator.row_count());
    if (options_.fit.weights.size() > 0) all.array() *= options_.fit.weights.array();
    return all;
  }

  double cost_of(const SequenceEvaluator& evaluator, const Eigen::VectorXd& residuals) const {
    const Eigen::VectorXd weight = weights(evaluator);
    double cost = 0.0;
    for (Eigen::Index i = 0; i < residuals.size(); ++i)
      cost += weight[i] * loss_at(options_.fit.loss, residuals[i] * residuals[i]).rho;
    return cost;
  }

  /// Step 1, in a point that may have its evaluator already.
  Expected<void> fit_elastic(const Eigen::VectorXd& from, Point& point, int iterations) const {
    const model::Model start = model_at(point.energy_max, from);
    if (!point.evaluator) {
      auto made = SequenceEvaluator::make(start, sequences_, options_.sequences);
      if (!made) return tl::unexpected(made.error());
      point.evaluator = std::make_unique<SequenceEvaluator>(std::move(*made));
    }
    point.evaluator->set_accuracy(Accuracy::exact);
    FitOptions options = options_.fit;
    options.max_iterations = std::min(options.max_iterations, iterations);
    point.fit = fit(*point.evaluator, start, options);
    if (!point.fit.usable && !point.evaluator->failure().empty())
      point.fit.message += ": " + point.evaluator->failure();
    if (point.fit.usable) point.cost = cost_of(*point.evaluator, point.fit.residuals);
    return {};
  }

  Expected<Point> fitted(double energy_max, const Eigen::VectorXd& from,
                         int iterations = kAll) const {
    Point point;
    point.energy_max = energy_max;
    if (auto ok = fit_elastic(from, point, iterations); !ok) return tl::unexpected(ok.error());
    return point;
  }

  /// At the fitted parameters, brought to rest exactly.
  Expected<LimitChange> change_at(Point& point) const {
    const Eigen::VectorXd& p = point.fit.parameters;
    point.evaluator->set_accuracy(Accuracy::exact);
    if (point.evaluator->evaluate(p, point.fit.residuals, &point.fit.jacobian) !=
        mechanics::PathStatus::ok)
      return fail(ErrorKind::refused, point.evaluator->failure());
    return limit_change(*point.evaluator, model_at(point.energy_max, p), p, id(),
                        options_.sequences);
  }

  /// Shares of the largest density, downwards until the cost rises from a lower one than without
  /// the limit: far below the truth equilibria are hard to find. Then the model's own value, if it
  /// lies between these.
  Expected<Point> best_start(double given, double largest, const Eigen::VectorXd& from) {
    Point best;
    double lowest = largest;
    const auto consider = [&](double energy_max) -> Expected<bool> {
      auto point = fitted(energy_max, best.fit.usable ? best.fit.parameters : from, kForStart);
      if (!point) return tl::unexpected(point.error());
      result_.stopped = point->fit.stopped;
      lowest = std::min(lowest, energy_max);
      const bool is_better = point->fit.usable && point->cost < best.cost;
      if (is_better) best = std::move(*point);
      return is_better;
    };
    for (const double share : kStarts) {
      const auto is_better = consider(share * largest);
      if (!is_better) return tl::unexpected(is_better.error());
      const bool is_enough = best.fit.usable && result_.cost_without - best.cost >
                                                    kRise * inflation(best.fit, options_.fit);
      if (result_.stopped || (!*is_better && is_enough)) break;
    }
    if (!result_.stopped && given > lowest && given < largest)
      if (auto ok = consider(given); !ok) return tl::unexpected(ok.error());
    return best;
  }

  Expected<Descent> descent(Point& point) const {
    auto change = change_at(point);
    if (!change) return tl::unexpected(change.error());
    const FitResult& at = point.fit;
    Descent descent;
    descent.change = std::move(*change);
    descent.follow.setZero(at.parameters.size());
    Eigen::VectorXd weight = weights(*point.evaluator);
    for (Eigen::Index i = 0; i < weight.size(); ++i)
      weight[i] *= loss_at(options_.fit.loss, at.residuals[i] * at.residuals[i]).by_s;
    const Eigen::VectorXd roots = weight.cwiseSqrt();
    std::vector<Eigen::Index> moving;
    for (std::size_t i = 0; i < at.states.size(); ++i)
      if (at.states[i] == ParameterState::free) moving.push_back(static_cast<Eigen::Index>(i));
    Eigen::MatrixXd j = roots.asDiagonal() * at.jacobian(Eigen::all, moving);
    Eigen::VectorXd g = roots.asDiagonal() * descent.change.column;
    const Eigen::VectorXd r = roots.asDiagonal() * at.residuals;
    if (!moving.empty()) {
      const Eigen::VectorXd norm = j.colwise().norm().cwiseMax(1e-300);
      j = j * norm.cwiseInverse().asDiagonal();
      const Eigen::VectorXd follow = -(j.transpose() * j).ldlt().solve(j.transpose() * g);
      g += j * follow;
      for (std::size_t k = 0; k < moving.size(); ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        descent.follow[moving[k]] = follow[i] / norm[i];
      }
    }
    const double curvature = g.squaredNorm();
    // a share of a standard error larger than Psi_max itself is nothing to go by
    if (!(curvature * point.energy_max * point.energy_max > 1e-6)) return descent;
    descent.std_error = 1.0 / std::sqrt(curvature);
    descent.step = std::clamp(-g.dot(r) / curvature, -0.5 * point.energy_max, point.energy_max);
    return descent;
  }

  /// The Gauss-Newton step and its halves, then smaller and smaller steps to both sides: the cost
  /// has kinks where elements come to the limit or leave it, and its slope there says little.
  static std::vector<double> lengths(const Descent& along, double energy_max) {
    constexpr int kHalvings = 4;
    std::vector<double> all;
    all.reserve(std::size_t{3} * kHalvings);
    for (int i = 0; i < kHalvings; ++i) all.push_back(std::ldexp(along.step, -i));
    const double around = std::min(2.0 * along.std_error, 0.5 * energy_max);
    for (int i = 0; i < kHalvings; ++i)
      for (const double side : {1.0, -1.0}) all.push_back(side * std::ldexp(around, -i));
    return all;
  }

  /// Step 2; the point is left as it is where no length of the step lowers the cost.
  Expected<bool> move_limit(const Descent& along, Point& point) const {
    const std::vector<Sequence> sequences = started_from_rest(*point.evaluator);
    for (const double length : lengths(along, point.energy_max)) {
      Point next;
      next.energy_max = point.energy_max + length;
      Eigen::VectorXd p = point.fit.parameters + length * along.follow;
      const auto bounds = parameters_of(model_);
      for (Eigen::Index k = 0; k < p.size(); ++k) {
        const model::Parameter& of = *bounds[static_cast<std::size_t>(k)];
        if (of.lower) p[k] = std::max(p[k], *of.lower);
        if (of.upper) p[k] = std::min(p[k], *of.upper);
      }
      auto made =
          SequenceEvaluator::make(model_at(next.energy_max, p), sequences, options_.sequences);
      if (!made) return tl::unexpected(made.error());
      next.evaluator = std::make_unique<SequenceEvaluator>(std::move(*made));
      Eigen::VectorXd residuals;
      if (next.evaluator->evaluate(p, residuals, nullptr) != mechanics::PathStatus::ok) continue;
      if (!(cost_of(*next.evaluator, residuals) < point.cost)) continue;
      if (auto ok = fit_elastic(p, next, kAll); !ok) return tl::unexpected(ok.error());
      if (!next.fit.usable) continue;
      point = std::move(next);
      return true;
    }
    return false;
  }

  Expected<void> alternate(Point& point) {
    if (auto ok = fit_elastic(Eigen::VectorXd(point.fit.parameters), point, kAll); !ok) return ok;
    if (!point.fit.usable) return fail(ErrorKind::refused, point.fit.message);
    result_.rounds.push_back({point.energy_max, point.cost, point.fit.iterations});
    for (int round = 0; round < options_.max_rounds; ++round) {
      const auto along = descent(point);
      if (!along) return tl::unexpected(along.error());
      const double limit_before = point.energy_max;
      const Eigen::VectorXd before = point.fit.parameters;
      if (along->std_error == 0.0 || std::abs(along->step) < options_.settled * along->std_error) {
        result_.converged = true;
        return {};
      }
      const auto moved = move_limit(*along, point);
      if (!moved) return tl::unexpected(moved.error());
      result_.stopped = point.fit.stopped;
      if (result_.stopped) return {};
      if (!*moved) {
        result_.step_left = along->step / along->std_error;
        return {};
      }
      result_.rounds.push_back({point.energy_max, point.cost, point.fit.iterations});
      double largest = std::abs(point.energy_max - limit_before) / along->std_error;
      for (Eigen::Index i = 0; i < before.size(); ++i)
        if (point.fit.std_error[i] > 0.0)
          largest = std::max(
              largest, std::abs(point.fit.parameters[i] - before[i]) / point.fit.std_error[i]);
      if (largest < options_.settled) {
        result_.converged = true;
        return {};
      }
    }
    return {};
  }

  /// Errors and correlations of all that is free together, Psi_max as one parameter more.
  Expected<LimitFit> determined(Point& point) {
    const auto change = change_at(point);
    if (!change) return tl::unexpected(change.error());
    const model::Model model = model_at(point.energy_max, point.fit.parameters);
    auto parameters = parameters_of(model);
    std::vector<int> free;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (!parameters[i]->fixed) free.push_back(static_cast<int>(i));
    const auto n = static_cast<Eigen::Index>(parameters.size());
    model::Parameter limit;
    limit.name = id();
    limit.value = point.energy_max;
    parameters.push_back(&limit);
    free.push_back(static_cast<int>(n));
    FitResult joint = point.fit;
    joint.parameters.conservativeResize(n + 1);
    joint.parameters[n] = point.energy_max;
    joint.jacobian.conservativeResize(Eigen::NoChange, n + 1);
    joint.jacobian.col(n) = change->column;
    describe_optimum(parameters, free, weights(*point.evaluator), options_.fit.loss,
                     point.evaluator->rows(), joint);
    result_.is_reached = joint.states.back() == ParameterState::free;
    result_.energy_max = point.energy_max;
    result_.std_error = joint.std_error[n];
    result_.correlation = joint.correlation.col(n).head(n);
    result_.active_frames = change->active_frames;
    result_.cost = point.cost;
    result_.elastic = std::move(point.fit);
    result_.elastic.states.assign(joint.states.begin(), joint.states.end() - 1);
    result_.elastic.std_error = joint.std_error.head(n);
    result_.elastic.correlation = joint.correlation.topLeftCorner(n, n);
    result_.elastic.effective_rows = joint.effective_rows;
    result_.message =
        sentence(result_.is_reached ? "is reached in %.0f frames: Psi_max is %.3g J/m^2"
                                    : "acts in %.0f frames, which do not determine Psi_max near "
                                      "%.3g J/m^2",
                 result_.active_frames, result_.energy_max);
    if (result_.step_left != 0.0)
      result_.message += "; no lower cost was found beside it, though its slope is not zero";
    return std::move(result_);
  }

  Expected<LimitFit> never_reached(Point& without, double largest) {
    result_.converged = without.fit.converged;
    result_.energy_max = largest;
    result_.cost = without.cost;
    const double width = inflation(without.fit, options_.fit);
    const auto rise_at = [&](double energy_max) -> Expected<double> {
      const auto point = fitted(energy_max, without.fit.parameters);
      if (!point) return tl::unexpected(point.error());
      return (point->cost - without.cost) / width;
    };
    // down from where nothing is at the limit, in growing steps, then between the last two
    double inside = largest, outside = largest, share = 0.05;
    bool is_outside = false, is_lower = false;
    while (!is_outside && share < 1.0) {
      inside = outside;
      outside = (1.0 - share) * largest;
      const auto rise = rise_at(outside);
      if (!rise) return tl::unexpected(rise.error());
      is_outside = *rise >= kRise;
      is_lower |= *rise < -kRise;
      share *= 2.0;
    }
    constexpr int kSteps = 5;
    for (int i = 0; is_outside && !is_lower && i < kSteps; ++i) {
      const double middle = 0.5 * (inside + outside);
      const auto rise = rise_at(middle);
      if (!rise) return tl::unexpected(rise.error());
      (*rise >= kRise ? outside : inside) = middle;
    }
    if (is_outside && !is_lower) result_.at_least = outside;
    result_.elastic = std::move(without.fit);
    result_.correlation.setZero(result_.elastic.parameters.size());
    result_.message =
        is_outside ? sentence(
                         "is never reached: the densities go to %.3g J/m^2, and Psi_max is at "
                         "least %.3g J/m^2",
                         largest, outside)
                   : sentence(
                         "is never reached, and nothing down to %.3g of %.3g J/m^2 says where "
                         "it could not be",
                         outside, largest);
    return std::move(result_);
  }

  Expected<LimitFit> stopped_at(Point& point) {
    result_.stopped = true;
    result_.energy_max = point.energy_max;
    result_.cost = point.cost;
    result_.elastic = std::move(point.fit);
    result_.message = "stopped";
    return std::move(result_);
  }

  std::string sentence(const char* format, double a, double b) const {
    char words[160];
    std::snprintf(words, sizeof words, format, a, b);
    return "the limit \"" + id() + "\" " + words;
  }

  model::Model model_;
  const std::vector<Sequence>& sequences_;
  std::size_t limit_;
  const LimitFitOptions& options_;
  LimitFit result_;
};

}  // namespace

Expected<LimitFit> fit_limit(const model::Model& model, const std::vector<Sequence>& sequences,
                             const std::string& limit, const LimitFitOptions& options) {
  if (auto ok = without_corrections(model); !ok) return tl::unexpected(ok.error());
  for (std::size_t i = 0; i < model.limits.size(); ++i)
    if (model.limits[i].id == limit) return LimitSearch(model, sequences, i, options).run();
  return bad_input("the model has no limit \"" + limit + "\"");
}

}  // namespace tenter::estimation
