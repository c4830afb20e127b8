// SPDX-License-Identifier: GPL-3.0-or-later
// A small part of the examination, with fixed seeds: the figures of design/diagnosis.md on it.
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/twin/exam/question.h"
#include "tests/twin/exam/sheet.h"
#include "tests/twin/exam/sit.h"

namespace tenter::exam {
namespace {

std::vector<Question> set(const Paper& paper) {
  const auto questions = set_questions(paper);
  EXPECT_TRUE(questions) << (questions ? "" : questions.error().message);
  return questions.value_or(std::vector<Question>());
}

/// Asks, prints the table, and keeps it beside the test as an artefact.
std::vector<Entry> sit_and_show(const std::vector<Question>& questions, const std::string& name) {
  std::vector<Entry> entries = sit(questions, 2);
  std::ostringstream table;
  write_table(entries, table);
  write_failures(entries, table);
  std::cout << table.str();
  std::ofstream(name + ".txt") << table.str();
  std::ofstream json(name + ".json");
  write_json(entries, json);
  return entries;
}

void expect_targets(const std::vector<Entry>& entries) {
  ASSERT_FALSE(entries.empty());
  for (const Figure& figure : figures(entries))
    EXPECT_TRUE(figure.met()) << figure.name << ": " << figure.count << " of " << figure.of;
}

TEST(Exam, EffectsNullsAndForeignOnes) {
  Paper paper;
  paper.seeds = 1;
  paper.nulls = 8;
  paper.foreign = true;
  paper.first_seed = 101;
  const std::vector<Question> questions = set(paper);
  ASSERT_GE(questions.size(), 13U * 2U + 3U * 2U + 8U);
  expect_targets(sit_and_show(questions, "exam_rich"));
}

TEST(Exam, SpecimensThatDifferAndSpecimensThatDoNot) {
  Paper paper;
  paper.effects = {"specimen_scatter", "load_cell_gain"};
  paper.suites = {"specimens"};
  paper.seeds = 1;
  paper.nulls = 2;
  paper.pairs = 1;
  paper.first_seed = 101;
  const std::vector<Question> questions = set(paper);
  ASSERT_EQ(questions.size(), 8U);
  expect_targets(sit_and_show(questions, "exam_specimens"));
}

TEST(Exam, FrictionAndViscosityAreNotToldApartWhereTheRateIsHidden) {
  Paper paper;
  paper.effects = {"internal_friction", "viscosity"};
  paper.suites = {"single_rate", "no_time"};
  paper.seeds = 1;
  paper.first_seed = 101;
  const std::vector<Question> questions = set(paper);
  ASSERT_EQ(questions.size(), 8U);
  expect_targets(sit_and_show(questions, "exam_hidden_rate"));
}

}  // namespace
}  // namespace tenter::exam
