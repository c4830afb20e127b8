// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sheet/sheet_equilibrium.h"

#include <algorithm>
#include <cmath>

#include "common/base/one_thread.h"

namespace tenter::twin {

namespace {}  // namespace

SheetSolver::SheetSolver(const Sheet& sheet, const std::vector<int>& held) : sheet_(&sheet) {
  std::vector<int> place(static_cast<std::size_t>(sheet.unknown_count()), 0);
  for (const int n : held) place[static_cast<std::size_t>(n)] = -1;
  for (int n = 0; n < sheet.unknown_count(); ++n)
    if (place[static_cast<std::size_t>(n)] == 0) {
      place[static_cast<std::size_t>(n)] = static_cast<int>(free_.size());
      free_.push_back(n);
    }
  const auto spans = sheet.spans();
  std::vector<Eigen::Triplet<double>> entries;
  const auto visit = [&](auto use) {
    for (const auto& span : spans)
      for (const int column : span)
        for (const int row : span)
          use(place[static_cast<std::size_t>(row)], place[static_cast<std::size_t>(column)]);
  };
  visit([&](int row, int column) {
    if (column >= 0 && row >= column) entries.emplace_back(row, column, 0.0);
  });
  const auto size = static_cast<Eigen::Index>(free_.size());
  matrix_.resize(size, size);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  matrix_.makeCompressed();
  slots_.reserve(spans.size() * kSpanUnknowns * kSpanUnknowns);
  const int *starts = matrix_.outerIndexPtr(), *rows = matrix_.innerIndexPtr();
  visit([&](int row, int column) {
    if (column < 0 || row < column) {
      slots_.push_back(-1);
      return;
    }
    const int* found = std::lower_bound(rows + starts[column], rows + starts[column + 1], row);
    slots_.push_back(static_cast<int>(found - rows));
  });
  factor_.cholmod().print = 0;  // what is not positive definite is said by info()
  factor_.analyzePattern(matrix_);
}

double SheetSolver::assemble(const Eigen::VectorXd& x, double left_out) {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  return sheet_->evaluate(x, &gradient_, &slots_, matrix_.valuePtr(), left_out);
}

bool SheetSolver::factor(double raised_by) {
  if (raised_by == 0.0) {
    factor_.factorize(matrix_);
  } else {
    raised_ = matrix_;
    // the diagonal is the first entry of its column
    for (Eigen::Index d = 0; d < raised_.cols(); ++d)
      raised_.valuePtr()[raised_.outerIndexPtr()[d]] += raised_by;
    factor_.factorize(raised_);
  }
  return factor_.info() == Eigen::Success;
}

double SheetSolver::net_force_N() const {
  double sum = 0.0;
  for (const int n : free_) sum += gradient_[n] * gradient_[n];
  return std::sqrt(sum);
}

SheetRest SheetSolver::solve(Eigen::VectorXd& x, const SheetTolerance& tolerance) {
  const OneThread one_thread;
  SheetRest rest;
  double left_out = 0.0;  // share of the negative part
  Eigen::VectorXd trial = x, right(matrix_.cols());
  for (rest.iterations = 0; rest.iterations < tolerance.iterations; ++rest.iterations) {
    const double energy = assemble(x, left_out);
    rest.net_force_N = net_force_N();
    if (!std::isfinite(energy)) return rest;
    double raised_by = 0.0;
    while (!factor(raised_by)) {
      if (left_out < 1.0) {
        left_out = left_out == 0.0 ? 0.1 : std::min(1.0, 3.2 * left_out);
        assemble(x, left_out);
      } else {
        raised_by = std::max(10.0 * raised_by, 1e-6 * matrix_.diagonal().cwiseAbs().maxCoeff());
      }
    }
    const bool is_exact = left_out == 0.0 && raised_by == 0.0;
    if (rest.net_force_N <= tolerance.net_force_N && is_exact) {
      rest.converged = true;
      return rest;
    }
    for (std::size_t k = 0; k < free_.size(); ++k)
      right[static_cast<Eigen::Index>(k)] = -gradient_[free_[k]];
    const Eigen::VectorXd step = factor_.solve(right);
    const double slope = -step.dot(right);
    const double longest = step.cwiseAbs().maxCoeff();
    double fraction = std::min(1.0, tolerance.longest_move_m / longest);
    const bool is_whole = fraction == 1.0;
    bool falls = false;
    int cuts = 0;
    for (; cuts < 40 && !falls; ++cuts) {
      trial = x;
      for (std::size_t k = 0; k < free_.size(); ++k)
        trial[free_[k]] += fraction * step[static_cast<Eigen::Index>(k)];
      const double moved = sheet_->evaluate(trial, nullptr);
      // below the rounding of the energy a step of Newton's method is taken at its word
      const double rounding = 1e-13 * std::abs(energy);
      falls = std::isfinite(moved) && moved <= energy + 1e-4 * fraction * slope + rounding;
      if (!falls) fraction *= 0.5;
    }
    if (!falls) {
      if (left_out >= 1.0) return rest;
      left_out = left_out == 0.0 ? 0.1 : std::min(1.0, 3.2 * left_out);
      continue;
    }
    x = trial;
    if (cuts > 3)
      left_out = std::min(1.0, std::max(0.1, 2.0 * left_out));
    else if (is_whole && cuts == 1)
      left_out = left_out < 0.02 ? 0.0 : 0.3 * left_out;
  }
  return rest;
}

}  // namespace tenter::twin
