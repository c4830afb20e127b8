// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/hold_out.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace tenter::estimation {
namespace {

/// Label of the fold that a row belongs to.
int fold_label(const DataSet& data, const Row& row, const std::string& kind,
               std::map<std::string, int>& labels,
               const std::vector<std::vector<int>>& order_in_group) {
  const Curves& curves = data.curves[static_cast<std::size_t>(row.curve)];
  const int block = curves.block_of[static_cast<std::size_t>(row.frame)];
  const int run = curves.blocks[static_cast<std::size_t>(block)].run;
  std::string key;
  if (kind == "protocols")
    key = curves.runs[static_cast<std::size_t>(run)].group;
  else if (kind == "repeats")
    key = std::to_string(
        order_in_group[static_cast<std::size_t>(row.curve)][static_cast<std::size_t>(run)]);
  else if (kind == "runs")
    key = std::to_string(row.curve) + "/" + std::to_string(run);
  else
    key = std::to_string(row.block);
  return labels.emplace(key, static_cast<int>(labels.size())).first->second;
}

}  // namespace

const std::vector<std::string>& fold_kinds() {
  static const std::vector<std::string> kinds = {"protocols", "repeats", "runs", "blocks"};
  return kinds;
}

Folds folds_of(const std::string& kind, const std::vector<int>& member_of, int members, int most) {
  Folds folds;
  folds.kind = kind;
  const int count = std::min(members, most);
  if (members < (kind == "protocols" ? 3 : 2)) return folds;
  for (int k = 0; k < count; ++k) {
    Eigen::VectorXd training = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(member_of.size()));
    for (std::size_t r = 0; r < member_of.size(); ++r)
      if (member_of[r] % count == k) training[static_cast<Eigen::Index>(r)] = 0.0;
    folds.training.push_back(std::move(training));
  }
  return folds;
}

Folds make_folds(const DataSet& data, const std::vector<Row>& rows, const std::string& kind) {
  std::map<std::string, int> runs_in_group;
  std::vector<std::vector<int>> order(data.curves.size());
  for (std::size_t i = 0; i < data.curves.size(); ++i)
    for (const CurveRun& run : data.curves[i].runs) order[i].push_back(runs_in_group[run.group]++);
  std::map<std::string, int> labels;
  std::vector<int> label_of;
  label_of.reserve(rows.size());
  for (const Row& row : rows) label_of.push_back(fold_label(data, row, kind, labels, order));
  constexpr int kMostFolds = 8;
  return folds_of(kind, label_of, static_cast<int>(labels.size()), kMostFolds);
}

std::vector<std::size_t> added_parameters(const model::Model& larger, const model::Model& smaller) {
  const auto all = parameter_names(larger);
  const auto known = parameter_names(smaller);
  const auto all_parameters = parameters_of(larger);
  const auto known_parameters = parameters_of(smaller);
  std::vector<std::size_t> added;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto place = std::find(known.begin(), known.end(), all[i]);
    const bool was_free = place != known.end() &&
                          !known_parameters[static_cast<std::size_t>(place - known.begin())]->fixed;
    if (!all_parameters[i]->fixed && !was_free) added.push_back(i);
  }
  return added;
}

void keep_determined(Folds& folds, const FitResult& larger, const std::vector<std::size_t>& added) {
  constexpr double kLeastShare = 1.0 / 6.0;
  const auto moves = [&](std::size_t i) {
    return larger.states[i] == ParameterState::free || larger.states[i] == ParameterState::flat;
  };
  std::vector<Eigen::Index> columns;
  for (const std::size_t i : added)
    if (moves(i)) columns.push_back(static_cast<Eigen::Index>(i));
  const auto s = static_cast<Eigen::Index>(columns.size());
  if (s == 0) return;
  for (std::size_t i = 0; i < larger.states.size(); ++i)
    if (moves(i) && std::find(added.begin(), added.end(), i) == added.end())
      columns.push_back(static_cast<Eigen::Index>(i));
  const auto m = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd j(larger.residuals.size(), m);
  Eigen::VectorXd value(s);
  for (Eigen::Index c = 0; c < m; ++c) {
    const Eigen::Index i = columns[static_cast<std::size_t>(c)];
    const double norm = larger.jacobian.col(i).norm();
    j.col(c) = larger.jacobian.col(i) / norm;
    if (c < s) value[c] = larger.parameters[i] * norm;
  }
  // information of the added parameters with the others free: the Schur complement of the normal
  // matrix
  const auto wald = [&](const Eigen::MatrixXd& normal) {
    if (s == m) return value.dot(normal * value);
    Eigen::MatrixXd others = normal.bottomRightCorner(m - s, m - s);
    others.diagonal().array() += 1e-9;
    const Eigen::MatrixXd cross = normal.bottomLeftCorner(m - s, s);
    const Eigen::MatrixXd schur =
        normal.topLeftCorner(s, s) - cross.transpose() * others.ldlt().solve(cross);
    return value.dot(schur * value);
  };
  constexpr double kLeastOfOne = 1e-6;  // of a column's square
  const double whole = wald(j.transpose() * j);
  std::erase_if(folds.training, [&](const Eigen::VectorXd& training) {
    for (Eigen::Index c = 0; c < s; ++c)
      if (j.col(c).cwiseAbs2().dot(training) < kLeastOfOne) return true;
    return wald(j.transpose() * training.asDiagonal() * j) < kLeastShare * whole;
  });
}

HeldOut cross_validate(ResidualFunction& evaluator, const model::Model& model, const Folds& folds,
                       const FitOptions& options) {
  HeldOut result;
  if (folds.training.empty()) return result;
  result.residuals =
      Eigen::VectorXd::Constant(evaluator.row_count(), std::numeric_limits<double>::quiet_NaN());
  result.left_out = Eigen::VectorXd::Zero(evaluator.row_count());
  for (std::size_t k = 0; k < folds.training.size(); ++k) {
    const Eigen::VectorXd& training = folds.training[k];
    FitOptions fold = options;
    fold.weights = training;
    if (options.weights.size() > 0) fold.weights = training.cwiseProduct(options.weights);
    const FitResult fitted = fit(evaluator, model, fold);
    if (!fitted.usable) {
      result.failed_fold = static_cast<int>(k);
      return result;
    }
    for (Eigen::Index r = 0; r < training.size(); ++r)
      if (training[r] == 0.0) {
        result.residuals[r] = fitted.residuals[r];
        result.left_out[r] = 1.0;
        result.chi2 += fitted.residuals[r] * fitted.residuals[r];
      }
  }
  result.usable = true;
  return result;
}

}  // namespace tenter::estimation
