// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/separation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tenter::diagnosis {
namespace {

/// Rows of the kind that shows most of what is apart.
int telling_rows(const Eigen::VectorXd& apart, const std::vector<int>& kind) {
  if (kind.empty()) return static_cast<int>(apart.size());
  std::map<int, std::pair<double, int>> shown;  // chi2, rows
  for (Eigen::Index r = 0; r < apart.size(); ++r) {
    auto& [chi2, rows] = shown[kind[static_cast<std::size_t>(r)]];
    chi2 += apart[r] * apart[r];
    ++rows;
  }
  return std::ranges::max_element(shown, {}, [](const auto& one) { return one.second.first; })
      ->second.second;
}

/// S with the parameters of `moved` giving way.
Separation left_over(const Eigen::VectorXd& apart, const Foretold& moved, const Reference& known) {
  const auto columns = moving_columns(known);
  const estimation::RowMatrix old = known.fit.jacobian(Eigen::all, columns);
  Eigen::MatrixXd information = old.transpose() * old;
  // what the captures say nothing of may move as it likes, within numbers
  Eigen::VectorXd scale = information.diagonal();
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    scale[i] = std::max(scale[i], moved.jacobian.col(i).squaredNorm());
  const double tiny = 1e-9;
  information.diagonal() += tiny * scale + Eigen::VectorXd::Constant(scale.size(), 1e-300);
  const Eigen::MatrixXd whole = information + moved.jacobian.transpose() * moved.jacobian;
  const Eigen::VectorXd pull = moved.jacobian.transpose() * apart;
  const Eigen::VectorXd way = whole.ldlt().solve(pull);
  Separation result;
  result.chi2 = std::max(0.0, apart.squaredNorm() - pull.dot(way));
  result.rows = static_cast<int>(apart.size());
  result.telling_rows = telling_rows(apart - moved.jacobian * way, moved.kind);
  return result;
}

}  // namespace

std::vector<Eigen::Index> moving_columns(const Reference& at) {
  std::vector<Eigen::Index> moving;
  for (std::size_t i = 0; i < at.fit.states.size(); ++i)
    if (at.fit.states[i] == estimation::ParameterState::free ||
        at.fit.states[i] == estimation::ParameterState::flat)
      moving.push_back(static_cast<Eigen::Index>(i));
  return moving;
}

std::optional<Separation> separation(const std::vector<Foretold>& foretold,
                                     const std::vector<const Reference*>& rivals) {
  std::optional<Separation> least;
  for (std::size_t k = 1; k < foretold.size(); ++k) {
    const Eigen::VectorXd apart = foretold[0].whitened - foretold[k].whitened;
    const Separation first = left_over(apart, foretold[0], *rivals[0]);
    const Separation other = left_over(apart, foretold[k], *rivals[k]);
    Separation pair = first.chi2 < other.chi2 ? first : other;
    pair.largest_force = std::max(foretold[0].largest_force, foretold[k].largest_force);
    if (!std::isfinite(pair.chi2)) return std::nullopt;
    if (!least || pair.chi2 < least->chi2) least = pair;
  }
  return least;
}

}  // namespace tenter::diagnosis
