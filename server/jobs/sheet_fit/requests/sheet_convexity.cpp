// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/sheet_convexity.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/estimation/convexity/convex_fit.h"
#include "server/estimation/least_squares/objective.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/jobs/fit_requests.h"
#include "server/jobs/sheet_fit/certainty/optimum.h"

namespace tenter::jobs {
namespace {

using estimation::ConvexFitStatus;
using estimation::ConvexityConstraints;
using estimation::ConvexStatus;
using estimation::SequenceEvaluator;

// of an eigenvalue, relative to what the parameters of its term give: rounding
constexpr double kRounding = 1e-7;
constexpr const char* kConvexCurve = "convex_spline";

const char* words_of(ConvexStatus status) {
  switch (status) {
    case ConvexStatus::ok:
      return "projected once";
    case ConvexStatus::infeasible:
      return "no values within the bounds are convex, with the fixed ones as they are";
    case ConvexStatus::no_convergence:
      return "the projection used up its rounds";
  }
  return "";
}

const char* words_of(ConvexFitStatus status) {
  switch (status) {
    case ConvexFitStatus::converged:
      return "converged, every step projected";
    case ConvexFitStatus::iterations_used:
      return "the iterations were used up, every step projected";
    case ConvexFitStatus::no_start:
      return "the fitted parameters, once convex, have no equilibrium";
    case ConvexFitStatus::not_convex:
      return "the fitted parameters could not be projected";
    case ConvexFitStatus::stopped:
      return "stopped";
  }
  return "";
}

Eigen::VectorXd weights_of(const SequenceEvaluator& evaluator) {
  Eigen::VectorXd weights = evaluator.weights();
  if (weights.size() == 0) weights.setOnes(evaluator.row_count());
  return weights;
}

Expected<SequenceEvaluator> evaluator_of(const model::Model& model, const SheetFindings& found,
                                         const RequestWork& work) {
  return SequenceEvaluator::make(model, compared_sequences(found), sequence_options(work));
}

/// Rounding aside, which is judged by the size that the parameters had: a curve that was pressed to
/// zero has no size of its own.
bool is_convex(const ConvexityConstraints& constraints, const Eigen::VectorXd& parameters,
               const Eigen::VectorXd& sizes) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> least;
  constraints.add_broken(parameters, sizes.cwiseMax(constraints.sizes(parameters)), kRounding, rows,
                         least);
  return rows.empty();
}

/// What the rows count at these residuals, outliers less.
Eigen::VectorXd robust_weights(const SequenceEvaluator& evaluator,
                               const estimation::RobustLoss& loss, const Eigen::VectorXd& r) {
  Eigen::VectorXd weights = weights_of(evaluator);
  for (Eigen::Index i = 0; i < r.size(); ++i)
    weights[i] *= estimation::loss_at(loss, r[i] * r[i]).by_s;
  return weights;
}

double cost(const SequenceEvaluator& evaluator, const Eigen::VectorXd& r) {
  return weights_of(evaluator).dot(r.cwiseAbs2());
}

/// One projection by J'WJ. True where it has an equilibrium.
bool project(const ConvexityConstraints& constraints, const Eigen::VectorXd& r,
             const estimation::RowMatrix& j, const estimation::RobustLoss& loss,
             SequenceEvaluator& evaluator, Eigen::VectorXd& parameters, ConvexFound& result) {
  const Eigen::VectorXd weights = robust_weights(evaluator, loss, r);
  Eigen::MatrixXd metric = j.transpose() * weights.asDiagonal() * j;
  // what the data do not tell stays where it is, each parameter by its own size
  constexpr double kStays = 1e-6;
  const Eigen::VectorXd size = constraints.sizes(parameters);
  const double most = metric.diagonal().cwiseProduct(size.cwiseAbs2()).maxCoeff();
  const double largest = metric.diagonal().maxCoeff();
  for (Eigen::Index k = 0; k < size.size(); ++k)
    metric(k, k) += size[k] > 0.0 ? kStays * most / (size[k] * size[k]) : largest;
  // a distance that weighs directions so differently is met to fewer digits
  estimation::ProjectionOptions options;
  options.slack = 0.1 * kRounding;
  const auto at = estimation::project_onto_convex(constraints, parameters, metric, options);
  result.projections = 1;
  result.message = words_of(at.status);
  if (at.status != ConvexStatus::ok) return false;
  Eigen::VectorXd left;
  if (evaluator.evaluate(at.parameters, left, nullptr) != mechanics::PathStatus::ok) {
    result.message = "the projected parameters have no equilibrium: " + evaluator.failure();
    return false;
  }
  result.cost_after = cost(evaluator, left);
  parameters = at.parameters;
  return true;
}

/// True where it ends at something convex.
bool fit_on(const ConvexityConstraints& constraints, const RequestWork& work,
            SequenceEvaluator& evaluator, Eigen::VectorXd& parameters, ConvexFound& result) {
  estimation::ConvexFitOptions options;
  options.tolerance = 1e-4;
  options.on_iteration = [&](int iteration, double chi2) {
    work.report({"convex", "", iteration, chi2, work.fraction});
    return !work.stop.stop_requested();
  };
  const auto fitted = estimation::fit_convex(evaluator, parameters, constraints, options);
  result.projections = fitted.projections;
  result.iterations = fitted.iterations;
  result.message = words_of(fitted.status);
  if (fitted.status != ConvexFitStatus::converged &&
      fitted.status != ConvexFitStatus::iterations_used)
    return false;
  result.cost_after = fitted.chi2;
  parameters = fitted.parameters;
  return true;
}

/// Curves become convex ones of as many control points; one control point is convex already. No
/// parameter may go below zero.
Expected<void> replace_curves(model::Model& model) {
  for (model::Term& term : model.terms) {
    if (!is_made_convex(term.law.name))
      return bad_input("term \"" + term.id + "\": the law " + term.law.name +
                       " is not convex by construction");
    for (model::Parameter& p : term.law.parameters) p.lower = std::max(0.0, p.lower.value_or(0.0));
    const auto points = term.law.parameters.size();
    if (!estimation::is_spline(term.law) || points < 2 || term.law.name == kConvexCurve) continue;
    auto law = estimation::nearest_curve(term.law, kConvexCurve, static_cast<int>(points));
    if (!law) return tl::unexpected(law.error());
    term.law = std::move(*law);
  }
  return {};
}

/// True where the fit of the convex curves is usable; then it is in `model`.
Expected<bool> fit_replaced(const SheetFindings& found, const RequestWork& work,
                            model::Model& model, ConvexFound& result) {
  model::Model convex = model;
  if (auto ok = replace_curves(convex); !ok) return tl::unexpected(ok.error());
  auto evaluator = evaluator_of(convex, found, work);
  if (!evaluator) return tl::unexpected(evaluator.error());
  estimation::FitOptions options;
  options.method = estimation::FitMethod::bounded_marquardt;
  options.tolerance = 1e-4;
  options.max_iterations = 40;
  options.loss = found.options.loss;
  options.on_iteration = [&](int iteration, double chi2) {
    work.report({"convex", "", iteration, chi2, work.fraction});
    return !work.stop.stop_requested();
  };
  const auto fitted = estimation::fit(*evaluator, convex, options);
  result.iterations = fitted.iterations;
  result.message = "convex by construction: " + fitted.message;
  if (!fitted.usable) return false;
  result.cost_after = fitted.chi2;
  estimation::store(fitted, convex);
  model = std::move(convex);
  return true;
}

}  // namespace

Expected<ConvexFound> sheet_convexity(model::Model& model, const SheetFindings& found,
                                      const RequestWork& work) {
  const auto constraints = ConvexityConstraints::make(model);
  if (!constraints) return tl::unexpected(constraints.error());
  ConvexFound result;
  Eigen::VectorXd parameters = estimation::parameter_values(model);
  const Eigen::VectorXd sizes = constraints->sizes(parameters);
  if (const auto worst = constraints->worst(parameters); worst.term >= 0) {
    result.term = model.terms[static_cast<std::size_t>(worst.term)].id;
    result.strain = worst.strain;
    result.smallest = worst.smallest;
  }
  result.was_convex = is_convex(*constraints, parameters, sizes);
  auto evaluator = evaluator_of(model, found, work);
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd r;
  estimation::RowMatrix j;
  if (evaluator->evaluate(parameters, r, &j) != mechanics::PathStatus::ok)
    return fail(ErrorKind::refused, evaluator->failure());
  result.cost_before = result.cost_after = cost(*evaluator, r);
  if (found.options.convex == ConvexWay::by_construction) {
    const auto changed = fit_replaced(found, work, model, result);
    if (!changed) return tl::unexpected(changed.error());
    result.is_convex = *changed;
  } else {
    const bool changed =
        found.options.convex == ConvexWay::afterwards
            ? project(*constraints, r, j, found.options.loss, *evaluator, parameters, result)
            : fit_on(*constraints, work, *evaluator, parameters, result);
    const auto all = estimation::parameters_of(model);
    for (std::size_t k = 0; changed && k < all.size(); ++k) {
      double& value = all[k]->value;
      value = parameters[static_cast<Eigen::Index>(k)];
      // projections are right to rounding, documents to the last bit
      value = std::max(value, all[k]->lower.value_or(value));
      value = std::min(value, all[k]->upper.value_or(value));
    }
    result.is_convex = is_convex(*constraints, parameters, sizes);
  }
  if (work.stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
  return result;
}

}  // namespace tenter::jobs
