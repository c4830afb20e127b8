// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {
namespace {

using testing::Numbers;

model::Model with_fields() {
  model::Model model;
  model.fields.push_back({"cloth", 2, {0.0, 0.0, 0.1, 0.0, 0.1, 0.1, 0.02, 0.07}, 0.03});
  model.fields.push_back({"flesh", 3, {0.0, 0.0, 0.0, 0.1, 0.05, 0.02}, 0.04});
  return model;
}

Support rbf(const char* field, int sample) {
  const auto support = Support::make(with_fields(), {"rbf", field, sample});
  EXPECT_TRUE(support);
  return *support;
}

TEST(Support, EverywhereWeighsOne) {
  const auto support = Support::make(with_fields(), {});
  ASSERT_TRUE(support);
  EXPECT_TRUE(support->is_everywhere());
  EXPECT_EQ(support->weight(nullptr), 1.0);
}

TEST(Support, IsTheNormalisedGaussianOfItsSample) {
  const std::vector<double> samples = with_fields().fields[1].positions_m;
  Numbers numbers(41);
  for (int i = 0; i < 50; ++i) {
    const double x[3] = {numbers.between(-0.1, 0.2), numbers.between(-0.1, 0.2),
                         numbers.between(-0.1, 0.2)};
    double gaussian[2];
    for (int k = 0; k < 2; ++k) {
      double squared = 0.0;
      for (int a = 0; a < 3; ++a)
        squared += std::pow(x[a] - samples[static_cast<std::size_t>(3 * k + a)], 2);
      gaussian[k] = std::exp(-squared / (2.0 * 0.04 * 0.04));
    }
    const double expected = gaussian[1] / (gaussian[0] + gaussian[1]);
    EXPECT_NEAR(rbf("flesh", 2).weight(x), expected, 1e-13);
    EXPECT_EQ(rbf("flesh", 2).dimensions(), 3);
  }
}

TEST(Support, WeightsOfAFieldAddUpToOneEverywhere) {
  Numbers numbers(42);
  double least = 1.0;
  for (int i = 0; i < 200; ++i) {
    const double reach = i < 100 ? 0.2 : 1e3;  // far beyond what a Gaussian can be told from zero
    const double x[2] = {numbers.between(-reach, reach), numbers.between(-reach, reach)};
    double sum = 0.0;
    for (int k = 1; k <= 4; ++k) {
      const double w = rbf("cloth", k).weight(x);
      EXPECT_TRUE(w >= 0.0 && w <= 1.0);
      least = std::min(least, w);
      sum += w;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
  EXPECT_LT(least, 1e-3);
  const double middle[2] = {0.02, 0.07};
  EXPECT_GT(rbf("cloth", 4).weight(middle), 0.9);
}

TEST(Support, RefusesWhatTheModelDoesNotHave) {
  const model::Model model = with_fields();
  EXPECT_FALSE(Support::make(model, {"patch", "", 0}));
  EXPECT_FALSE(Support::make(model, {"rbf", "silk", 1}));
  EXPECT_FALSE(Support::make(model, {"rbf", "cloth", 0}));
  EXPECT_FALSE(Support::make(model, {"rbf", "cloth", 5}));
}

}  // namespace
}  // namespace tenter::mechanics
