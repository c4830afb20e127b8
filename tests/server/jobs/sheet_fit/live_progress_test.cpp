// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/live_progress.h"

#include <gtest/gtest.h>

#include <string>

#include "common/model/presets.h"
#include "server/estimation/prediction.h"

namespace tenter::jobs {
namespace {

TEST(ValuesInWords, CurvesOfSeveralControlPointsShowTheirShape) {
  model::Model model = model::preset("cloth_stvk_spline").value();
  model.terms.resize(2);
  model::Law& weft = model.terms[0].law;
  weft.range_hi = 0.1;
  weft.parameters.resize(2);
  model.terms[1].law.parameters.resize(1);
  Eigen::VectorXd p(3);
  // an even stiffness: stress grows evenly, by an eighth of its largest from one to the next
  p << 100.0, 100.0, 81.25;
  EXPECT_EQ(values_in_words(model, p),
            "weft 100 100 \u2582\u2583\u2584\u2585\u2586\u2587\u2588\u2588, warp 81.25");
  // softening: it falls in the end
  p << 100.0, 0.0, 81.25;
  const std::string soft = values_in_words(model, p);
  EXPECT_NE(soft.find("\u2588\u2588"), std::string::npos) << soft;
  EXPECT_NE(soft.find("\u2581, warp"), std::string::npos) << soft;
  // not chosen yet: there are no strains to show it over
  weft.range_hi = 0.0;
  EXPECT_EQ(values_in_words(model, p), "weft 100 0, warp 81.25");
}

TEST(ValuesInWords, AreBoundedHoweverManyTermsThereAre) {
  model::Model model = model::preset("cloth_stvk").value();
  while (model.terms.size() < 200) model.terms.push_back(model.terms[0]);
  const Eigen::VectorXd p = estimation::parameter_values(model);
  const std::string words = values_in_words(model, p);
  EXPECT_LE(words.size(), kMostWords + 5);
  EXPECT_GT(words.size(), kMostWords - 50);
  EXPECT_TRUE(words.ends_with(", ..."));
}

}  // namespace
}  // namespace tenter::jobs
