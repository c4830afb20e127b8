// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/splines/knot_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/model/catalogue.h"

namespace tenter::estimation {
namespace {

constexpr int kBins = 32;       // of a piece
constexpr double kEdge = 0.15;  // of a piece, that a new knot keeps from its ends

/// Share of a piece at which half of what is left in it lies below.
double halving_share(const std::vector<double>& bins) {
  const double half = 0.5 * std::accumulate(bins.begin(), bins.end(), 0.0);
  double below = 0.0;
  std::size_t bin = 0;
  while (bin + 1 < bins.size() && below + bins[bin] < half) below += bins[bin++];
  const double inside = bins[bin] > 0.0 ? (half - below) / bins[bin] : 0.5;
  return std::clamp((static_cast<double>(bin) + inside) / kBins, kEdge, 1.0 - kEdge);
}

void add_knot(const StrainHistogram& left, std::vector<double>& ends) {
  std::size_t chosen = 0;
  double most = 0.0, share = 0.5, widest = 0.0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const std::vector<double> bins = left.bins(ends[i], ends[i + 1], kBins);
    const double own = std::accumulate(bins.begin(), bins.end(), 0.0);
    const double width = ends[i + 1] - ends[i];
    if (own > most || (most == 0.0 && width > widest)) {
      chosen = i;
      share = own > 0.0 ? halving_share(bins) : 0.5;
    }
    most = std::max(most, own);
    widest = std::max(widest, width);
  }
  const double knot = ends[chosen] + share * (ends[chosen + 1] - ends[chosen]);
  ends.insert(ends.begin() + static_cast<std::ptrdiff_t>(chosen) + 1, knot);
}

}  // namespace

std::vector<std::vector<double>> frame_costs(
    const Eigen::VectorXd& residuals, const std::vector<Row>& rows,
    const std::vector<std::vector<mechanics::State>>& states) {
  std::vector<std::vector<double>> costs;
  costs.reserve(states.size());
  for (const auto& of_sequence : states) costs.emplace_back(of_sequence.size(), 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i)
    costs[static_cast<std::size_t>(rows[i].curve)][static_cast<std::size_t>(rows[i].frame)] +=
        std::pow(residuals[static_cast<Eigen::Index>(i)], 2);
  return costs;
}

std::vector<double> inner_knots(const model::Law& law, int points, const StrainHistogram& left) {
  std::vector<double> ends = {law.range_lo, law.range_hi};
  if (law.parameters.size() > 1) ends = model::spline_knots(law);
  while (static_cast<int>(ends.size()) < model::spline_pieces(law, points) + 1)
    add_knot(left, ends);
  return {ends.begin() + 1, ends.end() - 1};
}

}  // namespace tenter::estimation
