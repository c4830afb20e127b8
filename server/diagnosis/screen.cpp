// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screen.h"

#include <vector>

#include "server/diagnosis/screening/catalogue_screen.h"
#include "server/diagnosis/screening/null_twins.h"

namespace tenter::diagnosis {
namespace {

/// The model's own space and the null twins.
Ground make_ground(const estimation::FitResult& fit, const DataPointer& data,
                   const estimation::Noise& noise, const ScreenOptions& options, Screen& result) {
  Ground ground;
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < fit.states.size(); ++i)
    if (fit.states[i] == estimation::ParameterState::free ||
        fit.states[i] == estimation::ParameterState::flat)
      free.push_back(static_cast<Eigen::Index>(i));
  Eigen::MatrixXd own_columns(fit.residuals.size(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t c = 0; c < free.size(); ++c)
    own_columns.col(static_cast<Eigen::Index>(c)) = fit.jacobian.col(free[c]);
  ground.own = range_basis(own_columns);
  ground.twins = null_twins(data->rows(), noise, options.null_twins, options.seed);
  ground.left = fit.residuals;
  settle(ground);
  std::vector<double> twin_chi2;
  for (Eigen::Index k = 0; k < ground.twins.cols(); ++k)
    twin_chi2.push_back(ground.twins.col(k).squaredNorm());
  for (const double c : twin_chi2)
    result.expected_chi2 += c / static_cast<double>(twin_chi2.size());
  result.lack_of_fit = ground.left.squaredNorm() / percentile(twin_chi2, 0.95);
  return ground;
}

}  // namespace

Screen screen(const model::Model& fitted, const estimation::FitResult& fit, const DataPointer& data,
              const estimation::Noise& noise, const Excitation& excitation,
              const ScreenOptions& options) {
  Screen result;
  const Ground ground = make_ground(fit, data, noise, options, result);
  const auto source = [&](const Gathering& gathering, Ground& at, Eigen::MatrixXd& columns) {
    const model::Model all = gathering.model();
    auto evaluator = estimation::Evaluator::make(all, data);
    if (!evaluator) return false;
    Eigen::VectorXd residuals;
    estimation::RowMatrix jacobian;
    if (evaluator->evaluate(estimation::parameter_values(all), residuals, &jacobian) !=
        mechanics::PathStatus::ok)
      return false;
    at = ground;
    columns = jacobian;
    return true;
  };
  screen_catalogue(fitted, excitation, source, options, result);
  return result;
}

}  // namespace tenter::diagnosis
