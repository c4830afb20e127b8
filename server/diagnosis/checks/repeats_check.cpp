// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/repeats_check.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace tenter::diagnosis {
namespace {

/// Ratio to the 95 % threshold at which the chance of one of `pairs` alarms is 5 %: the screen's
/// statistic is a chi-squared.
double allowed_ratio(int pairs) {
  const boost::math::chi_squared one(1.0);
  return boost::math::quantile(one, 1.0 - 0.05 / pairs) / boost::math::quantile(one, 0.95);
}

/// Screens the rows on which `difference` is a number, all others left out.
Screen screen_rows(const Reference& at, const DataPointer& data, const Eigen::VectorXd& difference,
                   const estimation::Noise& noise, const Excitation& excitation,
                   const ScreenOptions& options) {
  auto part = std::make_shared<estimation::DataSet>(*data);
  const std::vector<estimation::Row> rows = data->rows();
  std::vector<Eigen::Index> kept;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto k = static_cast<Eigen::Index>(r);
    if (std::isfinite(difference[k]))
      kept.push_back(k);
    else
      part->left_out[static_cast<std::size_t>(rows[r].curve)][static_cast<std::size_t>(
          rows[r].channel)][static_cast<std::size_t>(rows[r].frame)] = true;
  }
  estimation::FitResult fit = at.fit;
  fit.residuals.resize(static_cast<Eigen::Index>(kept.size()));
  fit.jacobian.resize(static_cast<Eigen::Index>(kept.size()), at.fit.jacobian.cols());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    fit.residuals[static_cast<Eigen::Index>(k)] = difference[kept[k]];
    fit.jacobian.row(static_cast<Eigen::Index>(k)) = at.fit.jacobian.row(kept[k]);
  }
  fit.chi2 = fit.residuals.squaredNorm();
  // both repeats have the same parameters: nothing is fitted to what lies between them
  std::fill(fit.states.begin(), fit.states.end(), estimation::ParameterState::fixed);
  return screen(at.model, fit, part, noise, excitation, options);
}

}  // namespace

RepeatsCheck check_repeats(const Reference& at, const DataPointer& data,
                           const estimation::Noise& noise, const Excitation& excitation,
                           unsigned long long seed) {
  constexpr int kMostPairs = 4;
  constexpr int kTwins = 300;
  constexpr int kFewestRows = 10;
  RepeatsCheck check;
  const int repeats = estimation::later_repeats(*data);
  check.repeats = repeats;
  const int wanted = repeats < 3 ? 0 : std::min(repeats, kMostPairs);
  for (int which = 0; which < wanted; ++which) {
    const Eigen::VectorXd difference =
        estimation::repeat_difference(*data, data->rows(), at.fit.residuals, which);
    if (difference.array().isFinite().count() < kFewestRows) continue;
    ++check.pairs;
    const Screen found = screen_rows(at, data, difference, noise, excitation,
                                     {kTwins, seed + static_cast<unsigned long long>(which)});
    if (found.candidates.empty() || found.candidates.front().ratio <= check.ratio) continue;
    check.ratio = found.candidates.front().ratio;
    check.effect = found.candidates.front().effect->id;
    check.variant = found.candidates.front().variant.words;
  }
  if (check.pairs > 0) check.allowed = allowed_ratio(check.pairs);
  return check;
}

void report_repeats(Diagnosis& d, const RepeatsCheck& check) {
  if (check.repeats == 2)
    d.checklist.push_back({"WARNING", "Two repeats are too few to hold against each other",
                           "the null twins are drawn from the one difference between them"});
  if (check.pairs == 0) return;
  char figures[96];
  std::snprintf(figures, sizeof figures, "largest ratio %.2f of %.2f allowed, %d pair%s",
                check.ratio, check.allowed, check.pairs, check.pairs == 1 ? "" : "s");
  if (check.raised())
    d.checklist.push_back({"WARNING", "Repeats against each other raise " + check.effect,
                           check.variant + "; " + figures});
  else
    d.checklist.push_back({"OK", "Repeats against each other raise nothing", figures});
}

}  // namespace tenter::diagnosis
