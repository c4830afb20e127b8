// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/refined_solve.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "server/diagnosis/checks/convexity.h"
#include "server/diagnosis/prepare.h"
#include "server/diagnosis/verdicts/effect_size.h"

namespace tenter::diagnosis {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Standard normal by Box and Muller: the same numbers with every standard library.
double normal(std::mt19937_64& engine) {
  constexpr double kTwoPi = 6.283185307179586;
  const double u = (static_cast<double>(engine() >> 11) + 1.0) * 0x1.0p-53;
  const double v = static_cast<double>(engine() >> 11) * 0x1.0p-53;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * v);
}

bool is_amplitude(const model::Parameter& p) {
  return p.unit.find('N') != std::string::npos;
}

double within_bounds(const model::Parameter& p, double value) {
  if (p.lower) value = std::max(value, *p.lower);
  if (p.upper) value = std::min(value, *p.upper);
  return value;
}

/// A size for every parameter: its own, or a tenth of the largest of its unit where it is smaller.
Eigen::VectorXd sizes_of(const std::vector<const model::Parameter*>& parameters) {
  std::map<std::string, double> largest;
  for (const model::Parameter* p : parameters)
    largest[p->unit] = std::max(largest[p->unit], std::abs(p->value));
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    sizes[static_cast<Eigen::Index>(i)] =
        std::max({std::abs(parameters[i]->value), 0.1 * largest[parameters[i]->unit], 1e-6});
  return sizes;
}

Eigen::VectorXd perturbed(const std::vector<const model::Parameter*>& parameters,
                          const Eigen::VectorXd& sizes, std::mt19937_64& engine) {
  constexpr double kAmplitudes = 0.35;  // a factor of two is two standard deviations
  constexpr double kShapes = 1.15;      // a decade is two standard deviations
  Eigen::VectorXd x(sizes.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const model::Parameter& p = *parameters[i];
    const auto k = static_cast<Eigen::Index>(i);
    x[k] = p.value;
    if (p.fixed) continue;
    const double width = is_amplitude(p) ? kAmplitudes : kShapes;
    const double draw = normal(engine);
    const bool has_sign = p.lower && *p.lower >= 0.0;
    x[k] = within_bounds(
        p, has_sign ? sizes[k] * std::exp(width * draw) : p.value + width * sizes[k] * draw);
  }
  return x;
}

/// One Gauss-Newton step from `x`, held within the bounds; chi2 of the better of both ends.
double improve(estimation::Evaluator& evaluator,
               const std::vector<const model::Parameter*>& parameters, Eigen::VectorXd& x) {
  Eigen::VectorXd residuals;
  estimation::RowMatrix jacobian;
  if (evaluator.evaluate(x, residuals, &jacobian) != mechanics::PathStatus::ok) return kInfinite;
  const double chi2 = residuals.squaredNorm();
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (!parameters[i]->fixed && jacobian.col(static_cast<Eigen::Index>(i)).norm() > 0.0)
      free.push_back(static_cast<Eigen::Index>(i));
  if (free.empty() || !jacobian.allFinite()) return chi2;
  Eigen::MatrixXd columns(residuals.size(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t c = 0; c < free.size(); ++c)
    columns.col(static_cast<Eigen::Index>(c)) =
        jacobian.col(free[c]) / jacobian.col(free[c]).norm();
  const Eigen::VectorXd step = -columns.colPivHouseholderQr().solve(residuals);
  Eigen::VectorXd next = x;
  for (std::size_t c = 0; c < free.size(); ++c)
    next[free[c]] = within_bounds(
        *parameters[static_cast<std::size_t>(free[c])],
        x[free[c]] + step[static_cast<Eigen::Index>(c)] / jacobian.col(free[c]).norm());
  if (evaluator.evaluate(next, residuals, nullptr) != mechanics::PathStatus::ok ||
      !(residuals.squaredNorm() < chi2))
    return chi2;
  x = next;
  return residuals.squaredNorm();
}

model::Model with_values(model::Model model, const Eigen::VectorXd& values) {
  const auto parameters = estimation::parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i]->value = values[static_cast<Eigen::Index>(i)];
  return model;
}

/// The best of other starts, before its refit; nothing where no start has an equilibrium.
std::optional<model::Model> other_start(const Reference& at, const DataPointer& data,
                                        unsigned long long seed,
                                        const std::function<bool()>& keep_on) {
  constexpr int kStarts = 16;
  auto evaluator = estimation::Evaluator::make(at.model, data);
  if (!evaluator) return std::nullopt;
  const auto parameters = estimation::parameters_of(at.model);
  const Eigen::VectorXd sizes = sizes_of(parameters);
  std::mt19937_64 engine(seed);
  double best = kInfinite;
  Eigen::VectorXd chosen;
  for (int k = 0; k < kStarts && keep_on(); ++k) {
    Eigen::VectorXd x = perturbed(parameters, sizes, engine);
    const double chi2 = improve(*evaluator, parameters, x);
    if (!(chi2 < best)) continue;
    best = chi2;
    chosen = x;
  }
  if (chosen.size() == 0) return std::nullopt;
  return with_values(at.model, chosen);
}

/// A midpoint between each two frames of one run; it carries no reading.
estimation::Curves with_midpoints(const estimation::Curves& curves) {
  estimation::Curves fine = curves;
  const std::size_t n = curves.frame_count();
  std::vector<std::size_t> source;  // original frame, n for a midpoint
  mechanics::StrainPath& path = fine.path;
  path.q.clear();
  path.duration_s.clear();
  path.start.clear();
  fine.clock_s.clear();
  fine.frame.clear();
  fine.origin.clear();
  fine.block_of.clear();
  for (std::size_t f = 0; f < n; ++f) {
    const bool goes_on = curves.path.start[f] == mechanics::FrameStart::next && f > 0;
    const double duration = curves.path.duration_s[f] * (goes_on ? 0.5 : 1.0);
    for (int half = goes_on ? 0 : 1; half < 2; ++half) {
      const bool middle = half == 0;
      path.q.push_back(middle ? Eigen::Vector3d(0.5 * (curves.path.q[f - 1] + curves.path.q[f]))
                              : curves.path.q[f]);
      path.duration_s.push_back(duration);
      path.start.push_back(middle ? mechanics::FrameStart::next : curves.path.start[f]);
      fine.clock_s.push_back(middle ? 0.5 * (curves.clock_s[f - 1] + curves.clock_s[f])
                                    : curves.clock_s[f]);
      fine.frame.push_back(curves.frame[f]);
      fine.origin.push_back(curves.origin[f]);
      fine.block_of.push_back(curves.block_of[f]);
      source.push_back(middle ? n : f);
    }
  }
  std::vector<int> place(n + 1, static_cast<int>(source.size()));
  for (std::size_t k = 0; k < source.size(); ++k)
    if (source[k] < n) place[source[k]] = static_cast<int>(k);
  for (estimation::Block& b : fine.blocks) {
    b.first = place[static_cast<std::size_t>(b.first)];
    b.last = place[static_cast<std::size_t>(b.last)];
  }
  for (estimation::CurveRun& r : fine.runs) {
    r.first = place[static_cast<std::size_t>(r.first)];
    r.last = place[static_cast<std::size_t>(r.last)];
  }
  for (std::size_t c = 0; c < fine.channels.size(); ++c) {
    fine.channels[c].measured.assign(source.size(), std::numeric_limits<double>::quiet_NaN());
    fine.channels[c].sigma_per_frame.clear();
    for (std::size_t k = 0; k < source.size(); ++k)
      if (source[k] < n) fine.channels[c].measured[k] = curves.channels[c].measured[source[k]];
  }
  return fine;
}

/// Squared shift of the fit's residuals when each thinned reading is predicted as the mean over its
/// own frames, on the path with midpoints.
double shift_on_fine_path(const Reference& at, const estimation::DataSet& data,
                          const estimation::DataSet& whole) {
  auto fine = std::make_shared<estimation::DataSet>();
  fine->sigma = data.sigma;
  for (std::size_t i = 0; i < whole.curves.size(); ++i) {
    fine->curves.push_back(with_midpoints(whole.curves[i]));
    const estimation::Curves& curves = fine->curves.back();
    std::vector<std::vector<bool>> left_out;
    for (std::size_t c = 0; c < curves.channels.size(); ++c) {
      left_out.emplace_back(curves.frame_count());
      for (std::size_t f = 0; f < curves.frame_count(); ++f)
        left_out.back()[f] = whole.left_out[i][c][static_cast<std::size_t>(curves.origin[f])];
    }
    fine->left_out.push_back(std::move(left_out));
  }
  auto evaluator = estimation::Evaluator::make(at.model, fine);
  Eigen::VectorXd residuals;
  if (!evaluator ||
      evaluator->evaluate(at.fit.parameters, residuals, nullptr) != mechanics::PathStatus::ok)
    return 0.0;
  const std::vector<double> shown = evaluator->predicted(residuals);
  const std::vector<estimation::Row> rows = data.rows();
  std::size_t k = 0;
  double shift = 0.0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    // the readings from this row's first frame to that of the next row of its block
    const auto i = static_cast<std::size_t>(rows[r].curve);
    const estimation::Curves& thin = data.curves[i];
    const auto f = static_cast<std::size_t>(rows[r].frame);
    const bool has_next = f + 1 < thin.frame_count() && thin.block_of[f + 1] == thin.block_of[f];
    const int first = thin.origin[f];
    const int last = has_next ? thin.origin[f + 1] : std::numeric_limits<int>::max();
    double sum = 0.0;
    double count = 0.0;
    const auto& fine_rows = evaluator->rows();
    for (; k < fine_rows.size(); ++k) {
      const estimation::Row& at_row = fine_rows[k];
      if (at_row.curve != rows[r].curve || at_row.channel != rows[r].channel) break;
      const int origin = fine->curves[i].origin[static_cast<std::size_t>(at_row.frame)];
      if (at_row.block != rows[r].block || origin >= last) break;
      if (origin < first) continue;
      sum += shown[k];
      count += 1.0;
    }
    if (count == 0.0) continue;
    const double sigma = data.sigma_of(rows[r]);
    const double measured = thin.channels[static_cast<std::size_t>(rows[r].channel)].measured[f];
    const double refined = (sum / count - measured) / sigma;
    const double moved = refined - at.fit.residuals[static_cast<Eigen::Index>(r)];
    shift += moved * moved;
  }
  return shift;
}

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

double RefinedSolve::threshold() const {
  return kNumericalShare * std::max(chi2 - expected_chi2, expected_chi2);
}

RefinedSolve refined_solve(const Reference& at, const DataPointer& data,
                           const estimation::DataSet& whole, unsigned long long seed,
                           const std::function<bool()>& keep_on) {
  RefinedSolve solve;
  solve.chi2 = at.fit.chi2;
  solve.expected_chi2 =
      std::max(1.0, static_cast<double>(at.fit.residuals.size() - free_count(at.model)));
  solve.continued_chi2 = at.fit.chi2;
  solve.restarted_chi2 = kInfinite;
  solve.path_chi2 = shift_on_fine_path(at, *data, whole);
  if (solve.path_chi2 > solve.threshold()) solve.effect = "mesh_resolution";
  if (free_count(at.model) == 0) return solve;

  estimation::FitOptions options;
  options.max_iterations = 200;
  options.tolerance = 1e-10;
  options.on_iteration = [&](int, double) { return keep_on(); };
  auto continued = make_reference(at.model, data, options);
  if (continued) solve.continued_chi2 = std::min(solve.chi2, continued->fit.chi2);
  const auto start = other_start(at, data, seed, keep_on);
  auto restarted = start ? make_reference(*start, data, options) : continued;
  // an optimum that is better only where the energy runs away is none
  if (start && restarted && frames_made_unstable(at.model, restarted->model, *data) == 0)
    solve.restarted_chi2 = restarted->fit.chi2;

  const double gone_on = solve.chi2 - solve.continued_chi2;
  const double elsewhere = solve.chi2 - solve.restarted_chi2;
  if (elsewhere > solve.threshold() && elsewhere - gone_on > 0.5 * solve.threshold()) {
    solve.effect = "wrong_basin";
    solve.better = std::move(*restarted);
  } else if (gone_on > solve.threshold()) {
    solve.effect = "solver_tolerance";
    solve.better = std::move(*continued);
  } else if (!at.fit.converged && continued && continued->fit.converged &&
             continued->fit.chi2 <= solve.chi2) {
    solve.better = std::move(*continued);
  }
  return solve;
}

estimation::DataSet whole_data(const Diagnosis& d,
                               const std::vector<estimation::Outlier>& left_out) {
  estimation::DataSet whole;
  whole.curves = d.curves;
  whole.sigma = d.data->sigma;
  for (const estimation::Curves& c : d.curves)
    whole.left_out.emplace_back(c.channels.size(), std::vector<bool>(c.frame_count(), false));
  for (const estimation::Outlier& o : left_out)
    whole.left_out[static_cast<std::size_t>(o.curve)][static_cast<std::size_t>(o.channel)]
                  [static_cast<std::size_t>(o.frame)] = true;
  return whole;
}

void check_refined_solve(Diagnosis& d, const RefinedSolve& solve, const std::string& whose) {
  const std::string figures =
      "chi2 " + rounded(solve.chi2) + "; gone on with finer tolerances " +
      rounded(solve.continued_chi2) + "; from other starts " +
      (std::isfinite(solve.restarted_chi2) ? rounded(solve.restarted_chi2) : "no equilibrium") +
      "; shift on the finer path " + rounded(solve.path_chi2);
  if (solve.effect.empty())
    d.checklist.push_back({"OK", "A refined solve of " + whose + " changes nothing", figures});
  else
    d.checklist.push_back({"WARNING",
                           "A refined solve of " + whose + " changes the misfit (" + solve.effect +
                               ")" +
                               (solve.better     ? "; the better optimum is used"
                                : solve.overfits ? "; the other optimum predicts left-out data "
                                                   "worse and is not used"
                                                 : ""),
                           figures});
}

Verdict numerical_verdict(const Diagnosis& d, const RefinedSolve& solve, unsigned long long seed) {
  Verdict verdict;
  verdict.kind = VerdictKind::numerical;
  verdict.effect = solve.effect;
  const double best = std::min(solve.continued_chi2, solve.restarted_chi2);
  const double lack = std::max(solve.chi2 - solve.expected_chi2, 1e-300);
  const double moved =
      solve.effect == "mesh_resolution" ? solve.path_chi2 : std::max(0.0, solve.chi2 - best);
  const double share_of_lack = std::min(1.0, moved / lack);
  const std::string share = rounded(100.0 * share_of_lack) + " %";
  if (solve.better) {
    const SizeInterval size = effect_size(*d.data, d.baseline.fit, solve.better->fit, seed);
    verdict.size = size.size;
    verdict.size_lo = size.lo;
    verdict.size_hi = size.hi;
  }
  if (solve.effect == "wrong_basin")
    verdict.words = "The fit of the baseline had stopped in a wrong basin: from another start " +
                    share + " of what it missed beyond the noise goes, with the same model. " +
                    "The better optimum is used from here on.";
  else if (solve.effect == "solver_tolerance")
    verdict.words =
        "The fit of the baseline had stopped too early: gone on with finer "
        "tolerances it loses " +
        share + " of what it missed beyond the noise. " +
        "The better optimum is used from here on.";
  else
    verdict.words =
        "The path that the fit of the baseline follows is too coarse: on every "
        "measured frame and the points between, the residuals move by " +
        share + " of what is missed beyond the noise. Fit with more frames a branch.";
  verdict.evidence = {{"chi2", solve.chi2},
                      {"continued_chi2", solve.continued_chi2},
                      {"path_shift_chi2", solve.path_chi2},
                      {"expected_chi2", solve.expected_chi2},
                      {"share_of_lack_of_fit", share_of_lack}};
  if (std::isfinite(solve.restarted_chi2))
    verdict.evidence.emplace_back("restarted_chi2", solve.restarted_chi2);
  return verdict;
}

}  // namespace tenter::diagnosis
