// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/separation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tenter::diagnosis {
namespace {

using estimation::RowMatrix;

struct Foretold {
  Eigen::VectorXd whitened;  ///< predictions in sigmas, a row a reading
  RowMatrix jacobian;        ///< by the free parameters
  double largest_N_m = 0.0;
};

std::vector<Eigen::Index> free_columns(const Reference& at) {
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < at.fit.states.size(); ++i)
    if (at.fit.states[i] == estimation::ParameterState::free ||
        at.fit.states[i] == estimation::ParameterState::flat)
      free.push_back(static_cast<Eigen::Index>(i));
  return free;
}

std::optional<Foretold> foretell(const Reference& at,
                                 const std::shared_ptr<const estimation::DataSet>& next) {
  auto evaluator = estimation::Evaluator::make(at.model, next);
  if (!evaluator) return std::nullopt;
  Foretold result;
  RowMatrix jacobian;
  if (evaluator->evaluate(estimation::parameter_values(at.model), result.whitened, &jacobian) !=
      mechanics::PathStatus::ok)
    return std::nullopt;
  result.jacobian = jacobian(Eigen::all, free_columns(at));
  const auto& rows = evaluator->rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto& channel = next->curves.front().channels[static_cast<std::size_t>(rows[r].channel)];
    if (channel.is_stress)
      result.largest_N_m =
          std::max(result.largest_N_m, std::abs(result.whitened[static_cast<Eigen::Index>(r)]) *
                                           evaluator->sigma(static_cast<int>(r)));
  }
  return result;
}

/// S with the parameters of `moved` giving way.
double left_over(const Eigen::VectorXd& apart, const Foretold& moved, const Reference& known) {
  const RowMatrix old = known.fit.jacobian(Eigen::all, free_columns(known));
  Eigen::MatrixXd information = old.transpose() * old;
  // what the captures say nothing of may move as it likes, within numbers
  Eigen::VectorXd scale = information.diagonal();
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    scale[i] = std::max(scale[i], moved.jacobian.col(i).squaredNorm());
  const double tiny = 1e-9;
  information.diagonal() += tiny * scale + Eigen::VectorXd::Constant(scale.size(), 1e-300);
  const Eigen::MatrixXd whole = information + moved.jacobian.transpose() * moved.jacobian;
  const Eigen::VectorXd pull = moved.jacobian.transpose() * apart;
  return std::max(0.0, apart.squaredNorm() - pull.dot(whole.ldlt().solve(pull)));
}

}  // namespace

std::optional<Separation> separation(const Experiment& plan, const Reference& one,
                                     const Reference& other, const estimation::DataSet& data,
                                     int like) {
  const auto which = static_cast<std::size_t>(like);
  auto next = std::make_shared<estimation::DataSet>();
  next->curves.push_back(curves_of(plan, data.curves[which]));
  next->sigma.push_back(data.sigma[which]);
  auto& left_out = next->left_out.emplace_back();
  for (const auto& channel : next->curves.front().channels)
    left_out.emplace_back(channel.measured.size(), false);
  const auto first = foretell(one, next);
  const auto second = foretell(other, next);
  if (!first || !second) return std::nullopt;
  const Eigen::VectorXd apart = first->whitened - second->whitened;
  Separation result;
  result.rows = static_cast<int>(apart.size());
  result.largest_N_m = std::max(first->largest_N_m, second->largest_N_m);
  result.chi2 = std::min(left_over(apart, *first, one), left_over(apart, *second, other));
  if (!std::isfinite(result.chi2)) return std::nullopt;
  return result;
}

}  // namespace tenter::diagnosis
