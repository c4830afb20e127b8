// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/question.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/twin/hidden_effects.h"
#include "tests/twin/sheets/sheet_effects.h"

namespace tenter::exam {
namespace {

TEST(Questions, CoverEveryEffectSizeAndVariant) {
  Paper paper;
  paper.foreign = true;
  const auto questions = set_questions(paper);
  ASSERT_TRUE(questions);
  std::set<std::string> asked;
  for (const Question& question : *questions) {
    asked.insert(question.twin.effects.front());
    const twin::HiddenEffect* effect = twin::find_hidden_effect(question.twin.effects.front());
    ASSERT_NE(effect, nullptr);
    EXPECT_EQ(question.kind == Kind::foreign, effect->foreign);
    EXPECT_FALSE(question.rate_hidden);
  }
  for (const twin::HiddenEffect& effect : twin::hidden_effects()) {
    for (const std::string& variant : effect.variants)
      EXPECT_TRUE(asked.contains(effect.id + ":" + variant)) << effect.id << ":" << variant;
    if (effect.needs_specimens) continue;  // one suite alone shows it
    EXPECT_TRUE(!effect.variants.empty() || asked.contains(effect.id)) << effect.id;
  }
}

TEST(Questions, OfSpecimensAreOfTheSuiteThatHasSeveral) {
  Paper paper;
  paper.effects = {"specimen_scatter"};
  paper.suites = {"rich", "specimens"};
  const auto questions = set_questions(paper);
  ASSERT_TRUE(questions);
  ASSERT_FALSE(questions->empty());
  for (const Question& question : *questions) EXPECT_EQ(question.twin.suite, "specimens");
}

TEST(Questions, AskOnlyWhatTheSuiteCanShow) {
  Paper paper;
  paper.suites = {"no_time", "knit_like"};
  const auto questions = set_questions(paper);
  ASSERT_TRUE(questions);
  for (const Question& question : *questions) {
    EXPECT_FALSE(question.twin.suite == "no_time" && question.truth() == "load_cell_drift");
    EXPECT_FALSE(question.twin.suite == "knit_like" && question.truth() == "internal_friction");
    EXPECT_EQ(question.rate_hidden,
              question.twin.suite == "no_time" &&
                  (question.truth() == "viscosity" || question.truth() == "internal_friction" ||
                   question.truth() == "strain_dependent_friction"));
  }
}

TEST(Questions, NullTwinsHideNothing) {
  Paper paper;
  paper.effects = {"viscosity"};
  paper.seeds = 0;
  paper.nulls = 5;
  const auto questions = set_questions(paper);
  ASSERT_TRUE(questions);
  ASSERT_EQ(questions->size(), 5U);
  for (const Question& question : *questions) {
    EXPECT_EQ(question.kind, Kind::null);
    EXPECT_EQ(question.twin.size, 0.0);
  }
}

TEST(Questions, OfSheetsAreOfWhatSheetsCanHide) {
  Paper paper;
  paper.suites = {"sheet_field", "sheet_no_time"};
  paper.foreign = true;
  paper.seeds = 2;
  const auto questions = set_questions(paper);
  ASSERT_TRUE(questions);
  std::set<std::string> in_field;
  for (const Question& question : *questions) {
    const bool is_field = question.twin.suite == "sheet_field";
    if (is_field) in_field.insert(question.truth());
    EXPECT_FALSE(!is_field && question.truth() == "force_camera_delay");
    EXPECT_EQ(question.rate_hidden, !is_field && is_rate_question(question.truth()));
  }
  EXPECT_EQ(in_field.size(), twin::sheet_effects().size());
  EXPECT_TRUE(in_field.contains("heterogeneity"));
}

TEST(Questions, RefuseWhatNobodyKnows) {
  Paper suite;
  suite.suites = {"poor"};
  EXPECT_FALSE(set_questions(suite));
  Paper effect;
  effect.effects = {"gremlins"};
  EXPECT_FALSE(set_questions(effect));
}

}  // namespace
}  // namespace tenter::exam
