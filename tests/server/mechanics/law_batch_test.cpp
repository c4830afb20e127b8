// SPDX-License-Identifier: GPL-3.0-or-later
// Laws over many strains at once: the answers of single evaluations, for every law there is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "server/mechanics/law.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::Numbers;

constexpr int kCount = 203;

/// Arrays of one batch, full of numbers that must not survive.
struct Arrays {
  explicit Arrays(int strains) {
    for (int i = 0; i < strains; ++i) {
      strain[i].resize(kCount);
      stress[i].assign(kCount, std::numeric_limits<double>::quiet_NaN());
      for (int j = i; j < strains; ++j) tangent[i][j] = stress[i];
    }
    energy = stress[0];
  }
  LawBatch batch(int strains, bool wants_energy, bool wants_tangent) {
    LawBatch batch;
    batch.count = kCount;
    batch.energy = wants_energy ? energy.data() : nullptr;
    for (int i = 0; i < strains; ++i) {
      batch.strain[i] = strain[i].data();
      batch.stress[i] = stress[i].data();
      for (int j = i; wants_tangent && j < strains; ++j) batch.tangent[i][j] = tangent[i][j].data();
    }
    return batch;
  }
  std::vector<double> strain[kMaxStrains], energy, stress[kMaxStrains];
  std::vector<double> tangent[kMaxStrains][kMaxStrains];
};

void compare(const model::Law& description, int strains, Numbers& numbers) {
  const auto made = make_law(description, strains);
  ASSERT_TRUE(made) << description.name;
  const Law& law = **made;
  const std::string words = description.name + " on " + std::to_string(strains);
  std::vector<double> parameters;
  for (const model::Parameter& p : description.parameters) parameters.push_back(p.value);

  Arrays arrays(strains);
  for (int i = 0; i < strains; ++i)
    for (double& e : arrays.strain[i]) e = numbers.between(-0.08, 0.16);
  for (int i = 0; i < strains; ++i) {  // the range's ends, a control point and rest
    arrays.strain[i][3] = -0.02;
    arrays.strain[i][4] = 0.1;
    arrays.strain[i][5] = 0.04;
    arrays.strain[i][6] = 0.0;
  }
  law.evaluate_batch(parameters.data(), arrays.batch(strains, true, true));
  Comparison energy(words + ": energy"), stress(words + ": stress"), tangent(words + ": tangent");
  const double state[kMaxLawState] = {};
  for (std::size_t e = 0; e < kCount; ++e) {
    double strain[kMaxStrains] = {};
    for (int i = 0; i < strains; ++i) strain[i] = arrays.strain[i][e];
    LawOutput out{};
    law.evaluate({strain, parameters.data(), state, 0.0}, out);
    energy.add(arrays.energy[e], out.energy);
    for (int i = 0; i < strains; ++i) {
      stress.add(arrays.stress[i][e], out.stress[i]);
      for (int j = i; j < strains; ++j) tangent.add(arrays.tangent[i][j][e], out.tangent[i][j]);
    }
  }
  const bool may_vanish = law.state_count() > 0;
  energy.judge(1e-13, may_vanish ? 0.0 : 1e-3);
  stress.judge(1e-13, may_vanish ? 0.0 : 1e-2);
  tangent.judge(1e-12, may_vanish || description.name == "constant_stress" ? 0.0 : 1.0);

  // what is not wanted is not needed for the rest
  Arrays bare(strains);
  for (int i = 0; i < strains; ++i) bare.strain[i] = arrays.strain[i];
  law.evaluate_batch(parameters.data(), bare.batch(strains, false, false));
  for (int i = 0; i < strains; ++i) EXPECT_EQ(bare.stress[i], arrays.stress[i]) << words;
  EXPECT_TRUE(std::isnan(bare.energy[0]));
  EXPECT_TRUE(std::isnan(bare.tangent[0][0][0]));

  Comparison by_parameter(words + ": stress by parameter");
  for (int p = 0; p < law.parameter_count(); ++p) {
    law.stress_by_parameter_batch(parameters.data(), p, bare.batch(strains, false, false));
    for (std::size_t e = 0; e < kCount; ++e) {
      double strain[kMaxStrains] = {};
      for (int i = 0; i < strains; ++i) strain[i] = arrays.strain[i][e];
      LawOutput out{};
      law.evaluate({strain, parameters.data(), state, 0.0}, out);
      for (int i = 0; i < strains; ++i)
        by_parameter.add(bare.stress[i][e], out.stress_by_parameter[i][p]);
    }
  }
  by_parameter.judge(1e-13, may_vanish ? 0.0 : 1e-3);
}

/// From random states: stresses and ends of single evaluations, and their derivatives.
void compare_with_a_past(const model::Law& description, int strains, Numbers& numbers) {
  const auto law = make_law(description, strains).value();
  const std::string words = description.name + " on " + std::to_string(strains);
  std::vector<double> parameters;
  for (const model::Parameter& p : description.parameters) parameters.push_back(p.value);
  Arrays arrays(strains);
  LawBatch batch = arrays.batch(strains, true, true);
  batch.duration_s = 0.3;
  std::vector<double> start[kMaxLawState], end[kMaxLawState];
  for (int s = 0; s < law->state_count(); ++s) {
    end[s].assign(kCount, std::numeric_limits<double>::quiet_NaN());
    for (int e = 0; e < kCount; ++e) start[s].push_back(numbers.between(-0.05, 0.05));
    batch.state[s] = start[s].data();
    batch.end_state[s] = end[s].data();
  }
  for (int i = 0; i < strains; ++i)
    for (double& e : arrays.strain[i]) e = numbers.between(-0.08, 0.16);
  Arrays by_last = arrays;
  LawBatch last = by_last.batch(strains, false, false);
  std::copy_n(batch.state, kMaxLawState, last.state);
  last.duration_s = batch.duration_s;
  law->evaluate_batch(parameters.data(), batch);
  law->stress_by_parameter_batch(parameters.data(), law->parameter_count() - 1, last);
  Comparison energy(words + ": energy"), stress(words + ": stress"), tangent(words + ": tangent"),
      ends(words + ": end"), by_parameter(words + ": by the last parameter");
  for (std::size_t e = 0; e < kCount; ++e) {
    double strain[kMaxStrains] = {}, state[kMaxLawState] = {};
    for (int i = 0; i < strains; ++i) strain[i] = arrays.strain[i][e];
    for (int s = 0; s < law->state_count(); ++s) state[s] = start[s][e];
    LawOutput out{};
    law->evaluate({strain, parameters.data(), state, batch.duration_s}, out);
    energy.add(arrays.energy[e], out.energy);
    for (int s = 0; s < law->state_count(); ++s) ends.add(end[s][e], out.state[s]);
    for (int i = 0; i < strains; ++i) {
      stress.add(arrays.stress[i][e], out.stress[i]);
      by_parameter.add(by_last.stress[i][e],
                       out.stress_by_parameter[i][law->parameter_count() - 1]);
      for (int j = i; j < strains; ++j) tangent.add(arrays.tangent[i][j][e], out.tangent[i][j]);
    }
  }
  energy.judge(1e-13, 1e-4);
  stress.judge(1e-13, 1e-3);
  tangent.judge(1e-12, 1e-1);
  ends.judge(1e-13, 1e-2);
  by_parameter.judge(1e-13, 1e-3);
}

TEST(LawBatch, AnswersAsEveryLawOfTheCatalogueDoes) {
  ASSERT_GE(model::law_catalogue().size(), 12U);
  Numbers numbers(11);
  for (const model::LawRow& row : model::law_catalogue()) {
    for (int strains = 1; strains <= kMaxStrains; ++strains) {
      if (row.strains != 0 && row.strains != strains) continue;
      for (const int points : {1, 4, 5, 9, kMaxLawParameters}) {
        if (row.spline ? points < row.min_points : points > 1) continue;
        if (row.grid && points == 5) continue;
        model::Law description;
        description.name = row.name;
        if (row.spline) {
          description.range_lo = -0.02;
          description.range_hi = 0.1;
        }
        description.parameters = model::default_parameters(row, points);
        for (model::Parameter& p : description.parameters)
          if (row.spline) p.value = numbers.between(0.0, 400.0);
        compare(description, strains, numbers);
        if (model::may_have_knots(description) && points > 4) {
          const int pieces = model::spline_pieces(description, points);
          for (int k = 1; k < pieces; ++k)
            description.knots.push_back(-0.02 + 0.12 * std::pow(1.0 * k / pieces, 1.7));
          compare(description, strains, numbers);
          description.knots.clear();
        }
        if (row.path_dependent) compare_with_a_past(description, strains, numbers);
      }
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics
