// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/mark.h"

#include <gtest/gtest.h>

#include "tests/twin/exam/sheet.h"

namespace tenter::exam {
namespace {

Question about(const std::string& truth) {
  Question question;
  question.truths = {truth};
  question.twin.effects = {truth};
  question.twin.size = 3.0;
  return question;
}

Answer saying(const std::vector<Said>& said) {
  Answer answer;
  answer.said = said;
  answer.achieved_size = 3.0;
  return answer;
}

const Said kNamedViscosity = {"NAMED", "viscosity", {}, 0.02, 0.01, 0.03};
const Said kUnexplained = {"UNEXPLAINED", "", {}, 0.02, 0.02, 0.02};
const Said kNothing = {"NOTHING_FOUND", "", {}, 0.0, 0.0, 0.0};
const Said kDrift = {"SENSOR", "load_cell_drift", {}, 0.02, 0.01, 0.03};

Said group(const std::vector<std::string>& ids) {
  return {"AMBIGUOUS", ids.front(), {ids.begin() + 1, ids.end()}, 0.02, 0.01, 0.03};
}

TEST(Mark, TheNameOfWhatHidesIsRight) {
  const Mark found = mark(about("viscosity"), saying({kNamedViscosity, kUnexplained}));
  EXPECT_EQ(found.grade, Grade::right);
  EXPECT_TRUE(found.certain);
  EXPECT_TRUE(found.unexplained);
}

TEST(Mark, AGroupThatHoldsItIsRightUpToThree) {
  const Question question = about("force_camera_delay");
  const Mark three =
      mark(question, saying({group({"viscosity", "internal_friction", "force_camera_delay"})}));
  EXPECT_EQ(three.grade, Grade::right);
  EXPECT_FALSE(three.certain);
  EXPECT_EQ(
      mark(question,
           saying({group({"viscosity", "internal_friction", "plastic_set", "force_camera_delay"})}))
          .grade,
      Grade::missed);
}

TEST(Mark, AGroupWithoutItDeniesIt) {
  const Mark found =
      mark(about("plastic_set"), saying({group({"viscosity", "internal_friction"})}));
  EXPECT_EQ(found.grade, Grade::wrong);
  EXPECT_EQ(found.wrong_groups, std::vector<std::string>{"viscosity"});
  EXPECT_TRUE(found.wrong_names.empty());
}

TEST(Mark, OneRightAndOneWrongIsPartly) {
  const Mark found = mark(about("viscosity"), saying({kNamedViscosity, kDrift}));
  EXPECT_EQ(found.grade, Grade::partly);
  EXPECT_EQ(found.wrong_names, std::vector<std::string>{"load_cell_drift"});
}

TEST(Mark, FrictionLawsStandForEachOtherAndNothingElseDoes) {
  EXPECT_TRUE(counts_as("internal_friction", "strain_dependent_friction"));
  EXPECT_TRUE(counts_as("strain_dependent_friction", "internal_friction"));
  EXPECT_FALSE(counts_as("internal_friction", "viscosity"));
  EXPECT_FALSE(counts_as("load_cell_offset", "load_cell_drift"));
}

TEST(Mark, OfAPairBothAreWanted) {
  Question question = about("viscosity");
  question.kind = Kind::pair;
  question.truths = {"viscosity", "load_cell_drift"};
  const Mark both = mark(question, saying({kNamedViscosity, kDrift}));
  EXPECT_EQ(both.grade, Grade::right);
  EXPECT_EQ(both.held, question.truths);
  const Mark one = mark(question, saying({kNamedViscosity, kUnexplained}));
  EXPECT_EQ(one.grade, Grade::partly);
  EXPECT_EQ(one.held, std::vector<std::string>{"viscosity"});
  // one group that holds both is no answer to which is which, but denies neither
  EXPECT_EQ(mark(question, saying({group({"viscosity", "load_cell_drift"})})).grade, Grade::right);
  EXPECT_EQ(mark(question, saying({group({"plastic_set", "clip_slip"})})).grade, Grade::wrong);
}

TEST(Mark, WhereTheRateIsHiddenOnlyTheGroupIsRight) {
  Question question = about("viscosity");
  question.rate_hidden = true;
  EXPECT_EQ(mark(question, saying({group({"internal_friction", "viscosity"})})).grade,
            Grade::right);
  EXPECT_EQ(mark(question, saying({kNamedViscosity})).grade, Grade::overclaimed);
  EXPECT_EQ(mark(question, saying({group({"viscosity", "force_camera_delay"})})).grade,
            Grade::overclaimed);
  EXPECT_EQ(mark(question, saying({kNothing})).grade, Grade::missed);
}

TEST(Mark, NullTwinsWantSilence) {
  Question question;
  question.kind = Kind::null;
  EXPECT_EQ(mark(question, saying({kNothing})).grade, Grade::right);
  EXPECT_EQ(mark(question, saying({kDrift})).grade, Grade::wrong);
  EXPECT_EQ(mark(question, saying({group({"viscosity", "internal_friction"})})).grade,
            Grade::wrong);
}

TEST(Mark, ForeignEffectsWantUnexplainedAndNoName) {
  Question question = about("backlash");
  question.kind = Kind::foreign;
  EXPECT_EQ(mark(question, saying({kUnexplained})).grade, Grade::right);
  EXPECT_EQ(mark(question, saying({kNothing})).grade, Grade::missed);
  EXPECT_EQ(mark(question, saying({kUnexplained, kNamedViscosity})).grade, Grade::wrong);
}

TEST(Mark, AFailedDiagnosisIsNoAnswer) {
  Answer failed;
  failed.trouble = "no fit";
  EXPECT_EQ(mark(about("viscosity"), failed).grade, Grade::no_answer);
  Question null;
  null.kind = Kind::null;
  EXPECT_EQ(mark(null, failed).grade, Grade::no_answer);
}

Entry entry(const Question& question, const Answer& answer) {
  return {question, answer, mark(question, answer)};
}

TEST(Figures, CountSharesAndJudgeThemByTheirTargets) {
  std::vector<Entry> entries;
  for (int i = 0; i < 19; ++i)
    entries.push_back(entry(about("viscosity"), saying({kNamedViscosity})));
  entries.push_back(entry(about("viscosity"), saying({kDrift})));
  const std::vector<Figure> list = figures(entries);
  EXPECT_EQ(list.front().count, 19);
  EXPECT_EQ(list.front().of, 20);
  EXPECT_TRUE(list.front().met());
  const auto wrong = std::find_if(list.begin(), list.end(), [](const Figure& figure) {
    return figure.name.starts_with("wrong names");
  });
  ASSERT_NE(wrong, list.end());
  EXPECT_EQ(wrong->count, 1);
  EXPECT_FALSE(wrong->met());
}

TEST(Figures, EffectsThatCouldNotBeMadeLargeEnoughDoNotCountTowardsRecall) {
  Answer weak = saying({kNothing});
  weak.achieved_size = 1.5;
  EXPECT_EQ(figures({entry(about("viscosity"), weak)}).front().of, 0);
}

TEST(Figures, ASilentDiagnosisMissesItsTarget) {
  const std::vector<Figure> list = figures({entry(about("viscosity"), saying({kNothing}))});
  EXPECT_FALSE(list.front().met());
}

TEST(Figures, CountCurvesAndSheetsApart) {
  Entry curves{about("viscosity"), saying({kNamedViscosity}), {}};
  curves.mark = mark(curves.question, curves.answer);
  Entry sheets = curves;
  sheets.question.twin.suite = "sheet_field";
  const auto kinds = apart({sheets, curves, sheets});
  ASSERT_EQ(kinds.size(), 2U);
  EXPECT_EQ(kinds[0].first, "curves");
  EXPECT_EQ(kinds[0].second.size(), 1U);
  EXPECT_EQ(kinds[1].first, "sheets");
  EXPECT_EQ(kinds[1].second.size(), 2U);
}

}  // namespace
}  // namespace tenter::exam
