// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/law_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/model/catalogue.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::testing {
namespace {

using mechanics::Law;
using mechanics::LawInput;
using mechanics::LawOutput;

/// All that a law is a function of.
struct Point {
  std::vector<double> strain, parameters, state;
  double duration_s = 0.0;
};

LawOutput at(const Law& law, const Point& point) {
  LawOutput out{};
  law.evaluate({point.strain.data(), point.parameters.data(), point.state.data(), point.duration_s},
               out);
  return out;
}

/// Differences need a neighbourhood without kinks: away from zero, the law's own bends, and what it
/// remembers.
bool is_smooth_here(const Point& point, std::vector<double> kinks, double margin) {
  kinks.push_back(0.0);
  const auto near_kink = [&](double value) {
    return std::any_of(kinks.begin(), kinks.end(),
                       [&](double kink) { return std::abs(value - kink) < margin; });
  };
  if (std::any_of(point.strain.begin(), point.strain.end(), near_kink)) return false;
  if (std::any_of(point.state.begin(), point.state.end(), near_kink)) return false;
  kinks = point.state;
  return std::none_of(point.strain.begin(), point.strain.end(), near_kink);
}

struct Checks {
  explicit Checks(const std::string& words)
      : stress(words + ": stress, of the energy"),
        tangent(words + ": tangent, of the stress"),
        stress_by_parameter(words + ": stress by parameter"),
        stress_by_state(words + ": stress by state"),
        state_by_strain(words + ": state by strain"),
        state_by_parameter(words + ": state by parameter"),
        state_by_state(words + ": state by state") {}
  Comparison stress, tangent, stress_by_parameter, stress_by_state, state_by_strain,
      state_by_parameter, state_by_state;
};

void check_by_strain(const Law& law, const Point& point, double h, Checks& checks) {
  const LawOutput here = at(law, point);
  for (int j = 0; j < law.strain_count(); ++j) {
    const auto ju = static_cast<std::size_t>(j);
    const auto moved = [&](double x) {
      Point other = point;
      other.strain[ju] = x;
      return at(law, other);
    };
    const double x = point.strain[ju];
    checks.stress.add(here.stress[j], difference([&](double e) { return moved(e).energy; }, x, h));
    for (int i = 0; i < law.strain_count(); ++i) {
      EXPECT_DOUBLE_EQ(here.tangent[i][j], here.tangent[j][i]);
      checks.tangent.add(here.tangent[i][j],
                         difference([&](double e) { return moved(e).stress[i]; }, x, h));
    }
    for (int s = 0; s < law.state_count(); ++s)
      checks.state_by_strain.add(here.state_by_strain[s][j],
                                 difference([&](double e) { return moved(e).state[s]; }, x, h));
  }
}

/// Parameters differ by orders of magnitude: derivatives are compared times the parameter's value.
void check_by_parameter(const Law& law, const Point& point, Checks& checks) {
  const LawOutput here = at(law, point);
  for (int k = 0; k < law.parameter_count(); ++k) {
    const auto ku = static_cast<std::size_t>(k);
    const double value = point.parameters[ku];
    const double unit = std::max(std::abs(value), 1e-3);
    const auto moved = [&](double x) {
      Point other = point;
      other.parameters[ku] = x;
      return at(law, other);
    };
    for (int i = 0; i < law.strain_count(); ++i)
      checks.stress_by_parameter.add(
          here.stress_by_parameter[i][k] * unit,
          difference([&](double p) { return moved(p).stress[i]; }, value, 1e-4 * unit) * unit);
    for (int s = 0; s < law.state_count(); ++s)
      checks.state_by_parameter.add(
          here.state_by_parameter[s][k] * unit,
          difference([&](double p) { return moved(p).state[s]; }, value, 1e-4 * unit) * unit);
  }
}

void check_by_state(const Law& law, const Point& point, double h, Checks& checks) {
  const LawOutput here = at(law, point);
  for (int r = 0; r < law.state_count(); ++r) {
    const auto ru = static_cast<std::size_t>(r);
    const auto moved = [&](double x) {
      Point other = point;
      other.state[ru] = x;
      return at(law, other);
    };
    for (int i = 0; i < law.strain_count(); ++i)
      checks.stress_by_state.add(
          here.stress_by_state[i][r],
          difference([&](double x) { return moved(x).stress[i]; }, point.state[ru], h));
    for (int s = 0; s < law.state_count(); ++s)
      checks.state_by_state.add(
          here.state_by_state[s][r],
          difference([&](double x) { return moved(x).state[s]; }, point.state[ru], h));
  }
}

void check_rest(const Law& law, const std::vector<double>& parameters, const std::string& words,
                bool stressed) {
  Point rest;
  rest.strain.assign(static_cast<std::size_t>(law.strain_count()), 0.0);
  rest.state.assign(static_cast<std::size_t>(law.state_count()), 0.0);
  rest.parameters = parameters;
  for (const double duration : {0.0, 1.0}) {
    rest.duration_s = duration;
    const LawOutput out = at(law, rest);
    EXPECT_EQ(out.energy, 0.0) << words;
    for (int i = 0; i < law.strain_count() && !stressed; ++i)
      EXPECT_EQ(out.stress[i], 0.0) << words;
    for (int s = 0; s < law.state_count(); ++s) EXPECT_EQ(out.state[s], 0.0) << words;
  }
}

}  // namespace

model::Law law_with(const std::string& name, const std::vector<double>& values, double lo,
                    double hi) {
  model::Law law;
  law.name = name;
  law.range_lo = lo;
  law.range_hi = hi;
  const model::LawRow* row = model::find_law(name);
  if (row == nullptr) {
    ADD_FAILURE() << "no law is called " << name;
    return law;
  }
  law.parameters = model::default_parameters(*row, static_cast<int>(values.size()));
  EXPECT_EQ(law.parameters.size(), values.size()) << name;
  for (std::size_t i = 0; i < values.size(); ++i) law.parameters[i].value = values[i];
  return law;
}

std::vector<double> values_of(const model::Law& law) {
  std::vector<double> values;
  for (const model::Parameter& parameter : law.parameters) values.push_back(parameter.value);
  return values;
}

void check_law(const LawCase& law_case) {
  const auto made = mechanics::make_law(law_case.law, law_case.strains);
  ASSERT_TRUE(made) << law_case.words << ": " << made.error().message;
  const Law& law = **made;
  const std::vector<double> parameters = values_of(law_case.law);
  check_rest(law, parameters, law_case.words, law_case.stressed_at_rest);

  Checks checks(law_case.words);
  Numbers numbers(law_case.seed);
  Point point;
  point.parameters = parameters;
  point.state.assign(static_cast<std::size_t>(law.state_count()), 0.0);
  int compared = 0;
  for (int step = 0; step < 200; ++step) {
    point.strain.clear();
    for (int i = 0; i < law_case.strains; ++i)
      point.strain.push_back(numbers.between(law_case.lo, law_case.hi));
    point.duration_s = law_case.step_s * numbers.between(0.1, 1.9);
    const LawOutput end = at(law, point);
    const LawOutput again = at(law, point);
    EXPECT_EQ(std::memcmp(end.stress, again.stress, sizeof(double) * point.strain.size()), 0);
    if (is_smooth_here(point, law_case.kinks, 4.0 * law_case.finest)) {
      ++compared;
      check_by_strain(law, point, law_case.finest, checks);
      check_by_parameter(law, point, checks);
      check_by_state(law, point, law_case.finest, checks);
    }
    point.state.assign(end.state, end.state + law.state_count());
  }
  EXPECT_GT(compared, 100) << law_case.words;
  checks.stress.judge();
  checks.tangent.judge(1e-6, law_case.has_tangent ? 1e-9 : 0.0);
  checks.stress_by_parameter.judge();
  const double may_vanish = law.state_count() > 0 ? 1e-9 : 0.0;
  checks.stress_by_state.judge(1e-6, may_vanish);
  checks.state_by_strain.judge(1e-6, may_vanish);
  checks.state_by_state.judge(1e-6, 0.0);
  checks.state_by_parameter.judge(1e-6, 0.0);
}

std::vector<double> follow_law(const Law& law, const std::vector<double>& parameters,
                               const std::vector<double>& strains, double step_s) {
  std::vector<double> stresses;
  Point point;
  point.parameters = parameters;
  point.state.assign(static_cast<std::size_t>(law.state_count()), 0.0);
  point.duration_s = step_s;
  for (const double strain : strains) {
    point.strain.assign(static_cast<std::size_t>(law.strain_count()), strain);
    const LawOutput out = at(law, point);
    point.state.assign(out.state, out.state + law.state_count());
    stresses.push_back(out.stress[0]);
  }
  return stresses;
}

}  // namespace tenter::testing
