// SPDX-License-Identifier: GPL-3.0-or-later
// How the searches for a least sum of squares end.
#pragma once

#include <functional>
#include <string>

namespace tenter::estimation {

struct SearchOptions {
  int max_iterations = 80;
  double tolerance = 1e-7;  ///< least fall of the cost, relative
  /// Called after each iteration with its number and cost; returns false to stop.
  std::function<bool(int, double)> on_iteration;
};

enum class SearchEnd {
  converged,     ///< a step lowers the cost by less than was asked, or would
  no_descent,    ///< no step, however short, lowers the cost
  out_of_steps,  ///< max_iterations reached
  stopped,       ///< by on_iteration
  no_start       ///< no equilibrium at the start
};

/// One sentence.
std::string describe(SearchEnd end);

struct SearchResult {
  SearchEnd end = SearchEnd::no_start;
  int iterations = 0;
  double cost = 0.0;

  bool is_converged() const { return end == SearchEnd::converged || end == SearchEnd::no_descent; }
};

}  // namespace tenter::estimation
