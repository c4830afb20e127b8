// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/tables/progressive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "common/model/catalogue.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/splines/strain_histogram.h"
#include "server/estimation/staged/start/equation_gap.h"

namespace tenter::estimation {
namespace {

constexpr int kCurvePoints = 5;
constexpr int kPrincipalPoints = 4;
enum Step { isotropic, anisotropic_stretch, nonlinear_stretch, shear_curve, area, cross_modal };

model::Term term_of(const std::string& id, const std::string& strain, const std::string& law,
                    int points = 1) {
  model::Term term;
  term.id = id;
  term.strain.name = strain;
  term.law.name = law;
  term.law.parameters =
      model::default_parameters(*model::find_law(law), points, model::find_strain(strain)->domain);
  return term;
}

model::Term curve_of(const std::string& id, const std::string& strain, int points, double lo,
                     double hi) {
  model::Term term = term_of(id, strain, "bspline_stiffness", points);
  term.law.range_lo = lo;
  term.law.range_hi = hi;
  return term;
}

/// The free numbers of a step by name, and where parameters get their shares of them.
class Numbers {
 public:
  explicit Numbers(const ProgressiveModel* before) {
    if (!before) return;
    for (const model::Parameter& p : before->ties.free) value_[p.name] = p.value;
  }

  /// The value that the step before found, else `otherwise`, else the default of the parameter.
  Eigen::Index add(const std::string& name, const model::Parameter& like,
                   std::optional<double> otherwise = std::nullopt) {
    model::Parameter p = like;
    p.name = name;
    const auto found = value_.find(name);
    if (found != value_.end())
      p.value = found->second;
    else if (otherwise)
      p.value = *otherwise;
    free_.push_back(std::move(p));
    return static_cast<Eigen::Index>(free_.size()) - 1;
  }

  /// What the step before found, or zero.
  double known(const std::string& name) const {
    const auto found = value_.find(name);
    return found == value_.end() ? 0.0 : found->second;
  }

  void share(const std::string& parameter, Eigen::Index column, double factor) {
    shares_.push_back({parameter, column, factor});
  }

  /// Puts map and values together with the model.
  ProgressiveModel finish(std::string name, model::Model model) const {
    ProgressiveModel result{std::move(name), std::move(model), {}};
    result.ties.free = free_;
    std::map<std::string, Eigen::Index> row;
    for (const std::string& p : parameter_names(result.model))
      row.emplace(p, static_cast<Eigen::Index>(row.size()));
    result.ties.map.setZero(static_cast<Eigen::Index>(row.size()),
                            static_cast<Eigen::Index>(free_.size()));
    for (const Share& s : shares_) result.ties.map(row.at(s.parameter), s.column) += s.factor;
    const Eigen::VectorXd all = result.ties.all(result.ties.values());
    const auto parameters = parameters_of(result.model);
    for (std::size_t k = 0; k < parameters.size(); ++k)
      parameters[k]->value = all[static_cast<Eigen::Index>(k)];
    return result;
  }

 private:
  struct Share {
    std::string parameter;
    Eigen::Index column;
    double factor;
  };
  std::map<std::string, double> value_;  ///< of the step before
  std::vector<model::Parameter> free_;
  std::vector<Share> shares_;
};

const char* name_of(int step) {
  static constexpr const char* kNames[kProgressiveSteps] = {
      "StVK", "A. Stretch", "Nl. Stretch", "A. Shear", "Area Pres.", "Cross-Modal"};
  return kNames[step];
}

std::string numbered(const std::string& stem, int k) {
  return stem + std::to_string(k + 1);
}

/// An addend of `count` numbers that begins at `start`, on the parameters of a term.
void add_addend(const std::string& stem, const std::string& term, int count, double start,
                const model::Parameter& like, Numbers& numbers) {
  for (int k = 0; k < count; ++k) {
    const bool is_curve = count > 1;
    const Eigen::Index column = numbers.add(is_curve ? numbered(stem + "_", k) : stem, like, start);
    numbers.share(term + (is_curve ? numbered(".k", k) : ".k"), column, 1.0);
  }
}

PooledResidual pooled(const std::vector<ScenarioResidual>& residuals) {
  PooledResidual result;
  double position = 0.0, force = 0.0, points = 0.0, rows = 0.0;
  for (const ScenarioResidual& r : residuals) {
    position += r.points * r.position_mm * r.position_mm;
    force += r.force_rows * r.force_N * r.force_N;
    points += r.points;
    rows += r.force_rows;
    result.restless += r.restless;
  }
  if (points > 0.0) result.position_mm = std::sqrt(position / points);
  if (rows > 0.0) result.force_N = std::sqrt(force / rows);
  return result;
}

Expected<PooledResidual> residual_of(const model::Model& model,
                                     const std::vector<RoleSequence>& sequences) {
  std::vector<ScenarioResidual> all;
  for (RoleSequence sequence : sequences) {
    sequence.role = Role::evaluation;  // positions and forces of all
    auto residual = scenario_residual(model, sequence);
    if (!residual) return tl::unexpected(residual.error());
    all.push_back(std::move(*residual));
  }
  return pooled(all);
}

}  // namespace

ProgressiveRanges progressive_ranges(const std::vector<std::vector<mechanics::State>>& states,
                                     const std::vector<RoleSequence>& sequences, double outliers) {
  model::Model probe;
  probe.terms = {term_of("u", "green_u", "linear"), term_of("v", "green_v", "linear"),
                 term_of("s", "green_uv", "linear"), term_of("p", "principal_stretches", "linear")};
  std::vector<StrainHistogram> histograms(probe.terms.size());
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const auto bound = mechanics::MeshModel::make(probe, sequences[s].sequence.cloth);
    if (bound) append(histograms, strain_histograms(*bound, states[s]));
  }
  constexpr double kLeast = 1e-3;
  ProgressiveRanges ranges;
  ranges.stretch_u = std::max(kLeast, histograms[0].range(outliers).second);
  ranges.stretch_v = std::max(kLeast, histograms[1].range(outliers).second);
  const auto [shear_lo, shear_hi] = histograms[2].range(outliers);
  ranges.shear = std::max({kLeast, -shear_lo, shear_hi});
  std::tie(ranges.principal_lo, ranges.principal_hi) = histograms[3].range(outliers);
  ranges.principal_hi = std::max(ranges.principal_hi, ranges.principal_lo + kLeast);
  return ranges;
}

ProgressiveModel progressive_model(int step, const ProgressiveRanges& ranges,
                                   const ProgressiveModel* before) {
  model::Model model;
  model.name = "progressive";
  const bool has_curves = step >= nonlinear_stretch;
  model.terms = {has_curves ? curve_of("weft", "green_u", kCurvePoints, 0.0, ranges.stretch_u)
                            : term_of("weft", "green_u", "linear"),
                 has_curves ? curve_of("warp", "green_v", kCurvePoints, 0.0, ranges.stretch_v)
                            : term_of("warp", "green_v", "linear"),
                 step >= shear_curve
                     ? curve_of("shear", "green_uv", kCurvePoints, -ranges.shear, ranges.shear)
                     : term_of("shear", "green_uv", "linear"),
                 term_of("coupling", "green_pair", "bilinear"),
                 term_of("bend_weft", "bend_u", "linear"),
                 term_of("bend_warp", "bend_v", "linear"),
                 term_of("bend_diagonal", "bend_d", "linear")};
  if (step >= area) model.terms.push_back(term_of("area", "area", "linear"));
  if (step >= cross_modal)
    model.terms.push_back(curve_of("principal", "principal_stretches", kPrincipalPoints,
                                   ranges.principal_lo, ranges.principal_hi));
  const model::Parameter stiffness = term_of("", "green_u", "linear").law.parameters.front();
  const model::Parameter bending = term_of("", "bend_u", "linear").law.parameters.front();
  Numbers numbers(before);

  // lambda + mu and mu, both not negative: convex in the strains, as is every addend by itself
  const Eigen::Index k = numbers.add("lambda_plus_mu", stiffness);
  const Eigen::Index mu = numbers.add("mu", stiffness);
  const auto on_all = [&](const std::string& term, int count, Eigen::Index column) {
    for (int j = 0; j < count; ++j)
      numbers.share(term + (count > 1 ? numbered(".k", j) : ".k"), column, 1.0);
  };
  const int of_stretch = has_curves ? kCurvePoints : 1;
  const int of_shear = step >= shear_curve ? kCurvePoints : 1;
  for (const char* id : {"weft", "warp"}) {
    on_all(id, of_stretch, k);
    on_all(id, of_stretch, mu);
  }
  on_all("shear", of_shear, mu);
  numbers.share("coupling.c", k, 1.0);
  numbers.share("coupling.c", mu, -1.0);
  if (step >= anisotropic_stretch) {
    add_addend("a_weft", "weft", of_stretch, numbers.known("a_weft"), stiffness, numbers);
    add_addend("a_warp", "warp", of_stretch, numbers.known("a_warp"), stiffness, numbers);
  }
  if (step >= shear_curve) add_addend("a_shear", "shear", of_shear, 0.0, stiffness, numbers);
  if (step >= area) add_addend("a_area", "area", 1, 0.0, stiffness, numbers);
  if (step >= cross_modal)
    add_addend("a_principal", "principal", kPrincipalPoints, 0.0, stiffness, numbers);
  for (const char* id : {"bend_weft", "bend_warp", "bend_diagonal"})
    numbers.share(std::string(id) + ".k", numbers.add(id, bending), 1.0);
  return numbers.finish(name_of(step), std::move(model));
}

Expected<std::vector<ProgressiveRow>> progressive_fit(const std::vector<RoleSequence>& training,
                                                      const std::vector<RoleSequence>& held_out,
                                                      const StageOptions& options) {
  ProgressiveModel now = progressive_model(isotropic, {}, nullptr);
  std::vector<Sequence> sequences;
  std::vector<GapSequence> shapes;
  sequences.reserve(training.size());
  shapes.reserve(training.size());
  for (const RoleSequence& s : training) sequences.push_back(s.sequence);
  for (const RoleSequence& s : training) shapes.push_back({&s.sequence, GapRows::all});
  if (const auto gap = equation_gap(now.model, now.ties, shapes, options.gap); gap)
    for (std::size_t k = 0; k < now.ties.free.size(); ++k)
      now.ties.free[k].value = gap->q[static_cast<Eigen::Index>(k)];
  int dropped = 0;
  for (Sequence& sequence : sequences) {
    const auto rest =
        resting_frames(now.model, sequence, now.ties.all(now.ties.values()), options.tolerance_N);
    if (!rest) return tl::unexpected(rest.error());
    dropped += static_cast<int>(rest->restless.size());
    keep_frames(sequence, rest->resting);
    if (sequence.frames.empty())
      return fail(ErrorKind::refused, "no frame of \"" + sequence.name + "\" has a rest");
  }

  SequenceOptions evaluating;
  evaluating.threads = options.threads;
  evaluating.tolerance_N = options.tolerance_N;
  evaluating.weighting = options.weighting;
  FitOptions fitting;
  fitting.method = options.method;
  fitting.max_iterations = options.max_iterations;
  fitting.tolerance = options.tolerance;
  ProgressiveRanges ranges;
  std::vector<ProgressiveRow> rows;
  for (int step = 0; step < kProgressiveSteps; ++step) {
    if (step > 0) now = progressive_model(step, ranges, &now);
    auto evaluator = SequenceEvaluator::make(now.model, sequences, evaluating);
    if (!evaluator) return tl::unexpected(evaluator.error());
    if (options.on_progress)
      fitting.on_iteration = [&](int iteration, double cost) {
        return options.on_progress({now.name, 0, iteration, cost});
      };
    Eigen::VectorXd q;
    const FitResult fit = fit_tied(*evaluator, now.ties, fitting, &q);
    if (!fit.usable && step == 0) return fail(ErrorKind::refused, now.name + ": " + fit.message);
    ProgressiveRow row{now.name, {}, fit.chi2, fit.iterations, fit.message, dropped, {}, {}};
    if (fit.usable && (rows.empty() || fit.chi2 <= rows.back().cost)) {
      store(fit, now.model);
      for (std::size_t k = 0; k < now.ties.free.size(); ++k)
        now.ties.free[k].value = q[static_cast<Eigen::Index>(k)];
      for (std::size_t s = 0; s < sequences.size(); ++s)
        for (std::size_t f = 0; f < sequences[s].frames.size(); ++f)
          sequences[s].frames[f].start = evaluator->states()[s][f];
      if (step <= anisotropic_stretch)
        ranges = progressive_ranges(evaluator->states(), training, options.outliers);
    } else {
      // `now` is still the special case that the step began as
      row.cost = rows.back().cost;
      row.message = "left as the step before: " +
                    (fit.usable ? std::string("the fit ended at a higher cost") : fit.message);
    }
    row.model = now.model;
    auto seen = residual_of(now.model, training);
    auto unseen = residual_of(now.model, held_out);
    if (!seen) return tl::unexpected(seen.error());
    if (!unseen) return tl::unexpected(unseen.error());
    row.training = *seen;
    row.held_out = *unseen;
    rows.push_back(std::move(row));
    if (fit.stopped) break;
  }
  return rows;
}

}  // namespace tenter::estimation
