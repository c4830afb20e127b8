// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/splines/spline_refinement.h"

#include <string>

#include "common/model/catalogue.h"
#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/mechanics/law.h"

namespace tenter::estimation {
namespace {

model::Law sized(const model::Law& law, int points, double value) {
  model::Law result = law;
  result.knots.clear();
  model::Parameter first = law.parameters.front();
  first.std_error.reset();
  first.interval_lo.reset();
  first.interval_hi.reset();
  const std::string_view stem = model::find_law(law.name)->parameters.front().name;
  result.parameters.assign(static_cast<std::size_t>(points), first);
  for (int k = 0; k < points; ++k) {
    model::Parameter& p = result.parameters[static_cast<std::size_t>(k)];
    p.name = std::string(stem) + std::to_string(k + 1);
    p.value = value;
  }
  return result;
}

/// Stress over strain, by each parameter: the basis functions of a stiffness.
Eigen::RowVectorXd basis_at(const mechanics::Law& law, double strain) {
  Eigen::RowVectorXd basis(law.parameter_count());
  const std::vector<double> ones(static_cast<std::size_t>(law.parameter_count()), 1.0);
  mechanics::LawOutput out{};
  mechanics::LawInput in;
  in.strain = &strain;
  in.parameters = ones.data();
  in.wants_energy = false;
  law.evaluate(in, out);
  for (Eigen::Index j = 0; j < basis.size(); ++j) basis[j] = out.stress_by_parameter[0][j] / strain;
  return basis;
}

}  // namespace

bool is_spline(const model::Law& law) {
  const model::LawRow* row = model::find_law(law.name);
  return row && row->spline && !row->grid && !law.parameters.empty() &&
         row->parameters.front().per_strain == 2;
}

Expected<model::Law> with_points(const model::Law& law, int points,
                                 const std::vector<double>& knots) {
  return nearest_curve(law, law.name, points, knots);
}

Expected<model::Law> nearest_curve(const model::Law& law, const std::string& name, int points,
                                   const std::vector<double>& knots) {
  model::Law result = law;
  result.name = name;
  for (const model::Law* of : {&law, static_cast<const model::Law*>(&result)})
    if (!is_spline(*of))
      return fail(ErrorKind::refused, "the law \"" + of->name + "\" is no stiffness spline");
  result = sized(result, points, law.parameters.front().value);
  result.knots = knots;
  const auto before = mechanics::make_law(law, 1);
  const auto after = mechanics::make_law(result, 1);
  if (!before) return tl::unexpected(before.error());
  if (!after) return tl::unexpected(after.error());
  if (!(law.range_hi > law.range_lo)) return result;

  const auto of_old = static_cast<Eigen::Index>(law.parameters.size());
  Eigen::VectorXd values(of_old), lower(points), upper(points);
  for (Eigen::Index j = 0; j < of_old; ++j)
    values[j] = law.parameters[static_cast<std::size_t>(j)].value;
  const model::Parameter& p = law.parameters.front();
  lower.setConstant(p.lower.value_or(-kNoBound));
  upper.setConstant(p.upper.value_or(kNoBound));
  const int samples = 16 * points;
  Eigen::MatrixXd a(samples, points);
  Eigen::VectorXd b(samples);
  for (int k = 0; k < samples; ++k) {
    // off the ends and the middle, so that no strain is zero
    double strain = law.range_lo + (law.range_hi - law.range_lo) * (k + 0.4321) / samples;
    if (strain == 0.0) strain = 1e-3 * (law.range_hi - law.range_lo);
    a.row(k) = basis_at(**after, strain);
    b[k] = basis_at(**before, strain).dot(values);
  }
  BoundedLeastSquares problem(points);
  problem.add(a, b);
  const BoundedSolution solution = problem.solve(lower, upper);
  for (int j = 0; j < points; ++j)
    result.parameters[static_cast<std::size_t>(j)].value = solution.x[j];
  return result;
}

model::Law as_constant(const model::Law& law) {
  double mean = 0.0;
  for (const model::Parameter& p : law.parameters)
    mean += p.value / static_cast<double>(law.parameters.size());
  return sized(law, std::max(1, model::find_law(law.name)->min_points), mean);
}

}  // namespace tenter::estimation
