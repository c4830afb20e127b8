// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/coverage.h"

#include <atomic>
#include <cmath>
#include <iterator>
#include <thread>
#include <utility>

#include "server/estimation/fit.h"
#include "server/estimation/prediction.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

namespace tenter::twin {

namespace {

struct Outcome {
  bool is_usable = false;
  bool is_restarted = false;
  double chi2_per_degree = 0.0;
  Eigen::VectorXd value, std_error;
};

Outcome fit_once(const std::vector<estimation::Sequence>& sequences, const model::Model& start) {
  estimation::SequenceOptions how;
  how.weighting.rule = estimation::WeightingRule::by_noise;
  auto evaluator = estimation::SequenceEvaluator::make(start, sequences, how);
  if (!evaluator) return {};
  const estimation::FitResult fitted = fit(*evaluator, start, {});
  const double degrees =
      static_cast<double>(evaluator->row_count()) - static_cast<double>(fitted.parameters.size());
  return {fitted.usable, false, fitted.chi2 / degrees, fitted.parameters, fitted.std_error};
}

// On the way from a poor start a frame may change to another buckled shape and stay there. The
// residual says so, and another start is tried.
Outcome fit_with_noise(int seed, std::vector<estimation::Sequence> sequences,
                       const model::Model& start) {
  Random random(stream_seed(static_cast<std::uint64_t>(seed), "rig"));
  for (estimation::Sequence& sequence : sequences) add_rig_noise({}, random, sequence);
  constexpr double kOffFloor = 1.3, kFurthest = 1.5;
  constexpr int kStarts = 5;
  Outcome best = fit_once(sequences, start);
  for (int k = 1; k < kStarts && !(best.is_usable && best.chi2_per_degree < kOffFloor); ++k) {
    model::Model other = start;
    for (model::Parameter* parameter : estimation::parameters_of(other))
      parameter->value *= random.log_uniform(1.0 / kFurthest, kFurthest);
    Outcome outcome = fit_once(sequences, other);
    if (outcome.is_usable && !(best.is_usable && best.chi2_per_degree < outcome.chi2_per_degree))
      best = outcome;
    best.is_restarted = true;
  }
  return best;
}

}  // namespace

Fabric reached_everywhere(Fabric fabric) {
  for (std::size_t m = 2; m < fabric.curves.size(); ++m)
    fabric.curves[m] = {0.0, 0.0, {fabric.curves[m].stiffness(0.0)}};
  return fabric;
}

std::vector<estimation::Sequence> fitting_sequences(const Fabric& fabric, int frames, int cells) {
  std::vector<estimation::Sequence> sequences;
  for (const char* name : {"stretch_u", "stretch_v", "shear", "bend_u", "bend_v"}) {
    const Protocol protocol = make_protocol(fabric, name, {.frames = frames, .cells = cells});
    sequences.push_back(same_mesh_twin(fabric, protocol, {.nodes = cells + 1}).value().sequence);
  }
  return sequences;
}

model::Model poor_start(model::Model truth) {
  constexpr double kOff[] = {1.4, 0.7, 1.5, 0.65, 1.3, 1.45};
  for (std::size_t m = 0; m < truth.terms.size(); ++m)
    for (model::Parameter& parameter : truth.terms[m].law.parameters)
      parameter.value *= kOff[m % std::size(kOff)];
  return truth;
}

Coverage coverage_of(const Fabric& fabric, const CoverageOptions& options) {
  const model::Model truth = fabric_model(fabric);
  const model::Model start = poor_start(truth);
  const auto sequences = fitting_sequences(fabric, options.frames, options.cells);
  std::vector<Outcome> outcomes(static_cast<std::size_t>(options.seeds));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int seed = next++; seed < options.seeds; seed = next++)
      outcomes[static_cast<std::size_t>(seed)] = fit_with_noise(seed, sequences, start);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < options.threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();

  Coverage result;
  for (const model::Term& term : truth.terms)
    for (const model::Parameter& parameter : term.law.parameters)
      result.parameters.push_back(
          {.name = term.id + "." + parameter.name, .truth = parameter.value});
  for (const Outcome& outcome : outcomes) {
    if (!outcome.is_usable) continue;
    ++result.usable;
    if (outcome.is_restarted) ++result.restarted;
    result.chi2_per_degree += outcome.chi2_per_degree;
  }
  result.chi2_per_degree /= result.usable;
  for (std::size_t p = 0; p < result.parameters.size(); ++p) {
    ParameterCoverage& row = result.parameters[p];
    const auto k = static_cast<Eigen::Index>(p);
    double squares = 0.0;
    for (const Outcome& outcome : outcomes) {
      if (!outcome.is_usable) continue;
      if (!(outcome.std_error[k] > 0.0)) {  // at a bound: no interval
        ++row.at_bound;
        continue;
      }
      const double off = (outcome.value[k] - row.truth) / outcome.std_error[k];
      constexpr double kQuantile = 1.96;  // of store() in estimation/fit.cpp
      if (std::abs(off) <= kQuantile) ++row.held;
      row.mean_off += off;
      squares += off * off;
      row.relative_error += outcome.std_error[k] / std::abs(row.truth);
    }
    const int inside = result.usable - row.at_bound;
    row.mean_off /= inside;
    squares /= inside;
    row.relative_error /= inside;
    row.spread = std::sqrt(squares - row.mean_off * row.mean_off);
  }
  return result;
}

std::pair<int, int> binomial_band(int trials, double probability, double tail) {
  // from one end towards the middle; logarithms, so that no factor underflows
  const auto chance = [&](int k) {
    return std::exp(std::lgamma(trials + 1.0) - std::lgamma(k + 1.0) -
                    std::lgamma(trials - k + 1.0) + k * std::log(probability) +
                    (trials - k) * std::log1p(-probability));
  };
  int fewest = 0, most = trials;
  for (double sum = chance(0); sum <= tail; sum += chance(fewest)) ++fewest;
  for (double sum = chance(trials); sum <= tail; sum += chance(most)) --most;
  return {fewest, most};
}

}  // namespace tenter::twin
