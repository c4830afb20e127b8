// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/friction_estimate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tenter::estimation {
namespace {

constexpr std::array<int, 5> kReported = {kK1, kK2, kA, kB, kTau};

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

std::string with_unit(double value, const std::string& unit) {
  return text_of(value) + (unit == "1" ? "" : " " + unit);
}

/// What is known of a number that the data do not tell.
std::string range_words(const FrictionNumber& number) {
  if (number.lo && number.hi)
    return "not told: somewhere between " + with_unit(*number.lo, number.unit) + " and " +
           with_unit(*number.hi, number.unit);
  if (number.hi) return "not told: at most " + with_unit(*number.hi, number.unit);
  if (number.lo) return "not told: at least " + with_unit(*number.lo, number.unit);
  return "not told: the data look the same for any value";
}

/// The number with which this one goes together, and by how much.
std::string partner_words(const FrictionEstimate& estimate, int parameter) {
  constexpr double kTogether = 0.95;
  const RowMatrix& correlation = estimate.fit.correlation;
  int partner = -1;
  double most = kTogether;
  for (const int other : kReported) {
    if (other == parameter || parameter >= correlation.rows()) continue;
    if (std::abs(correlation(parameter, other)) < most) continue;
    most = std::abs(correlation(parameter, other));
    partner = other;
  }
  if (partner < 0) return "";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), " (correlation %.3f)", correlation(parameter, partner));
  return "only a combination with " +
         parameters_of(estimate.model)[static_cast<std::size_t>(partner)]->name + " is told" +
         text.data();
}

std::string reason_words(const FrictionEstimate& estimate, int parameter,
                         const FrictionNumber& number, bool has_rival) {
  for (const ReadingsLack& lack : estimate.lacks)
    if (std::find(lack.numbers.begin(), lack.numbers.end(), number.name) != lack.numbers.end())
      return lack.words;
  if (has_rival) return "a value elsewhere, with other numbers beside it, fits as well";
  if (estimate.fit.states[static_cast<std::size_t>(parameter)] == ParameterState::zero_gradient)
    return "nothing that was read moves with it";
  if (std::string words = partner_words(estimate, parameter); !words.empty()) return words;
  if (number.name == "tau" && !number.lo)
    return "what it changes is over before the next reading, or below the noise";
  if (!number.lo) return "zero does as well, within the noise";
  return "the noise of the readings is too large for more";
}

/// Of all numbers that the data move, those at a bound among them: the truth beside a bound is not
/// on it, and the others' numbers are as uncertain as if it were free.
Eigen::VectorXd standard_errors(const FitResult& fit, const FitOptions& options) {
  std::vector<Eigen::Index> moving;
  bool has_bound = false;
  for (std::size_t i = 0; i < fit.states.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const bool is_bound = fit.states[i] == ParameterState::at_bound;
    if (!is_bound && fit.states[i] != ParameterState::free) continue;
    if (!(fit.jacobian.col(column).squaredNorm() > 0.0)) continue;
    has_bound = has_bound || is_bound;
    moving.push_back(column);
  }
  if (!has_bound) return fit.std_error;
  const Eigen::MatrixXd columns = fit.jacobian(Eigen::all, moving);
  const Eigen::VectorXd lengths = columns.colwise().norm();
  const Eigen::MatrixXd scaled = columns * lengths.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd covariance =
      (scaled.transpose() * scaled)
          .ldlt()
          .solve(Eigen::MatrixXd::Identity(scaled.cols(), scaled.cols()));
  const double width = std::sqrt(inflation(fit, options));
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(fit.std_error.size());
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    errors[moving[k]] = width * std::sqrt(std::max(0.0, covariance(c, c))) / lengths[c];
  }
  return errors;
}

void interval_from_covariance(const FitResult& fit, const Eigen::VectorXd& errors, int parameter,
                              const model::Parameter& p, FrictionNumber& number) {
  const ParameterState state = fit.states[static_cast<std::size_t>(parameter)];
  const double half = 1.959963984540054 * errors[parameter];
  if (state == ParameterState::at_bound && half > 0.0 && p.lower && number.value <= *p.lower + half)
    number.hi = number.value + half;
  if (state != ParameterState::free) return;
  if (!p.lower || number.value - half > *p.lower) number.lo = number.value - half;
  number.hi = number.value + half;
}

bool is_told(const FrictionNumber& number, const model::Parameter& p) {
  if (!number.lo || !number.hi) return false;
  constexpr double kWidest = 10.0;
  return !p.lower || *number.hi <= kWidest * *number.lo;
}

}  // namespace

void judge(const MakeFunction& make, const model::Model& start, const FrictionFitOptions& options,
           FrictionEstimate& estimate) {
  estimate.model = start;
  store(estimate.fit, estimate.model);
  estimate.gains_below = gains_below(values_of(estimate.fit.parameters));
  const auto parameters = parameters_of(estimate.model);
  if (options.profiles) {
    ProfileOptions how;
    how.threads = options.threads;
    how.scan = 1;
    for (const int i : kReported)
      if (!parameters[static_cast<std::size_t>(i)]->fixed) how.parameters.push_back(i);
    estimate.profiles = profiles(make, estimate.model, estimate.fit, options.fit, how);
  }
  estimate.numbers.clear();
  const Eigen::VectorXd errors = standard_errors(estimate.fit, options.fit);
  for (const int i : kReported) {
    model::Parameter& p = *parameters[static_cast<std::size_t>(i)];
    FrictionNumber number;
    number.name = p.name;
    number.unit = p.unit;
    number.value = estimate.fit.parameters[i];
    if (p.fixed) {
      number.is_told = true;
      estimate.numbers.push_back(number);
      continue;
    }
    const auto profile =
        std::find_if(estimate.profiles.begin(), estimate.profiles.end(),
                     [&](const Profile& candidate) { return candidate.parameter == i; });
    if (profile != estimate.profiles.end()) {
      number.lo = profile->lo;
      number.hi = profile->hi;
    } else {
      interval_from_covariance(estimate.fit, errors, i, p, number);
    }
    const bool has_rival =
        profile != estimate.profiles.end() && profile->determined == Determined::multimodal;
    number.is_told = !has_rival && is_told(number, p);
    if (!number.is_told)
      number.words = range_words(number) + "; " + reason_words(estimate, i, number, has_rival);
    p.interval_lo = number.lo;
    p.interval_hi = number.hi;
    estimate.numbers.push_back(number);
  }
}

}  // namespace tenter::estimation
