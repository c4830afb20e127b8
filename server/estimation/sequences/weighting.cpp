// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/weighting.h"

#include <cmath>
#include <string>

namespace tenter::estimation {
namespace {

/// The weight of a row by (3.6).
double by_thesis(const Sequence& sequence, const Observations& channels, int channel,
                 const ThesisFactors& factors) {
  const double sigma = channels.sigma(sequence, channel);
  switch (channels.kind(sequence, channel)) {
    case ObservationKind::position:
      return factors.mu_1_m2 * sigma * sigma;
    case ObservationKind::force:
      return factors.lambda_1_N2 * sigma * sigma;
    case ObservationKind::other:
      break;
  }
  return 0.0;
}

Expected<void> check_factors(const Weighting& weighting, std::size_t sequences) {
  if (weighting.rule != WeightingRule::thesis) return {};
  if (weighting.factors.size() != sequences)
    return bad_input("mu and lambda are given for " + std::to_string(weighting.factors.size()) +
                     " of " + std::to_string(sequences) + " sequences");
  for (const ThesisFactors& f : weighting.factors)
    for (const double factor : {f.mu_1_m2, f.lambda_1_N2})
      if (!(factor >= 0.0) || !std::isfinite(factor))
        return bad_input("mu or lambda is negative or no number");
  return {};
}

}  // namespace

Expected<Eigen::VectorXd> row_weights(const std::vector<Row>& rows,
                                      const std::vector<Sequence>& sequences,
                                      const Weighting& weighting) {
  if (auto ok = check_factors(weighting, sequences.size()); !ok) return tl::unexpected(ok.error());
  std::vector<double> rows_of(sequences.size(), 0.0);
  for (const Row& row : rows) rows_of[static_cast<std::size_t>(row.curve)] += 1.0;
  std::vector<Observations> channels;
  channels.reserve(sequences.size());
  for (const Sequence& sequence : sequences) channels.emplace_back(sequence);
  Eigen::VectorXd weights(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto s = static_cast<std::size_t>(rows[k].curve);
    double weight = sequences[s].weight;
    if (weighting.rule == WeightingRule::equal_protocols) weight /= rows_of[s];
    if (weighting.rule == WeightingRule::thesis)
      weight *= by_thesis(sequences[s], channels[s], rows[k].channel, weighting.factors[s]);
    weights[static_cast<Eigen::Index>(k)] = weight;
  }
  const auto counted = static_cast<double>((weights.array() > 0.0).count());
  if (counted == 0.0) return bad_input("no measured value has a weight above zero");
  // where all weigh the same they are exactly one
  const double largest = weights.maxCoeff();
  weights /= largest;
  return Eigen::VectorXd(weights / (weights.sum() / counted));
}

}  // namespace tenter::estimation
