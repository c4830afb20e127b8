// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/hold_out.h"

#include <Eigen/Dense>
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
    key = std::to_string(order_in_group[static_cast<std::size_t>(row.curve)][static_cast<std::size_t>(run)]);
  else if (kind == "runs")
    key = std::to_string(row.curve) + "/" + std::to_string(run);
  else
    key = std::to_string(row.block);
  return labels.emplace(key, static_cast<int>(labels.size())).first->second;
}

/// Every parameter that the whole data determine keeps at least a share of its information in each fold.
bool stays_determined(const FitResult& fit, const Folds& folds) {
  constexpr double kWorstInflation = 100.0;  // of a variance, by leaving a fold out
  std::vector<Eigen::Index> moving;
  for (std::size_t i = 0; i < fit.states.size(); ++i)
    if (fit.states[i] == ParameterState::free) moving.push_back(static_cast<Eigen::Index>(i));
  if (moving.empty()) return true;
  const auto m = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd j(fit.residuals.size(), m);
  for (Eigen::Index c = 0; c < m; ++c) {
    j.col(c) = fit.jacobian.col(moving[static_cast<std::size_t>(c)]);
    j.col(c) /= j.col(c).norm();
  }
  const auto variances = [&](const Eigen::MatrixXd& normal) {
    Eigen::MatrixXd regular = normal;
    regular.diagonal().array() += 1e-12;
    return Eigen::VectorXd(regular.ldlt().solve(Eigen::MatrixXd::Identity(m, m)).diagonal());
  };
  const Eigen::VectorXd whole = variances(j.transpose() * j);
  for (const Eigen::VectorXd& training : folds.training) {
    const Eigen::VectorXd part = variances(j.transpose() * training.asDiagonal() * j);
    if ((part.array() > kWorstInflation * whole.array()).any()) return false;
  }
  return true;
}

}  // namespace

Folds folds_of_kind(const DataSet& data, const std::vector<Row>& rows, const std::string& kind) {
  std::map<std::string, int> runs_in_group;
  std::vector<std::vector<int>> order(data.curves.size());
  for (std::size_t i = 0; i < data.curves.size(); ++i)
    for (const CurveRun& run : data.curves[i].runs) order[i].push_back(runs_in_group[run.group]++);
  std::map<std::string, int> labels;
  std::vector<int> label_of;
  for (const Row& row : rows) label_of.push_back(fold_label(data, row, kind, labels, order));
  Folds folds;
  folds.kind = kind;
  // many small members are gathered into at most eight folds, round robin
  constexpr int kMostFolds = 8;
  const int members = static_cast<int>(labels.size());
  const int count = std::min(members, kMostFolds);
  if (count < 2) return folds;
  for (int k = 0; k < count; ++k) {
    Eigen::VectorXd training = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (label_of[r] % count == k) training[static_cast<Eigen::Index>(r)] = 0.0;
    folds.training.push_back(std::move(training));
  }
  return folds;
}

Folds make_folds(const DataSet& data, const std::vector<Row>& rows, const FitResult& fit) {
  for (const char* kind : {"protocols", "repeats", "runs", "blocks"}) {
    const Folds folds = folds_of_kind(data, rows, kind);
    const std::size_t fewest = std::string(kind) == "protocols" ? 3 : 2;
    if (folds.training.size() < fewest) continue;
    if (stays_determined(fit, folds)) return folds;
  }
  return {};
}

HeldOut cross_validate(Evaluator& evaluator, const model::Model& model, const Folds& folds,
                       const FitOptions& options) {
  HeldOut result;
  if (folds.training.empty()) return result;
  result.residuals.setZero(evaluator.row_count());
  for (const Eigen::VectorXd& training : folds.training) {
    FitOptions fold = options;
    fold.weights = training;
    if (options.weights.size() > 0) fold.weights = training.cwiseProduct(options.weights);
    const FitResult fitted = fit(evaluator, model, fold);
    if (!fitted.usable) return result;
    for (Eigen::Index r = 0; r < training.size(); ++r)
      if (training[r] == 0.0) result.residuals[r] = fitted.residuals[r];
  }
  result.chi2 = result.residuals.squaredNorm();
  result.usable = true;
  return result;
}

}  // namespace tenter::estimation
