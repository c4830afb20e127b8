// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/search/search_result.h"

namespace tenter::estimation {

std::string describe(SearchEnd end) {
  switch (end) {
    case SearchEnd::converged:
      return "converged";
    case SearchEnd::no_descent:
      return "converged: no step lowers the cost";
    case SearchEnd::out_of_steps:
      return "the limit of iterations was reached";
    case SearchEnd::stopped:
      return "stopped";
    case SearchEnd::no_start:
      return "the model has no equilibrium at the start values";
  }
  return {};
}

}  // namespace tenter::estimation
