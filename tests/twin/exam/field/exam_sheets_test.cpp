// SPDX-License-Identifier: GPL-3.0-or-later
// A small part of the examination on sheets, with fixed seeds.
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

/// Asks, prints the table, and keeps it beside the test as an artefact.
std::vector<Entry> sit_and_show(const Paper& paper, const std::string& name) {
  const auto questions = set_questions(paper);
  EXPECT_TRUE(questions) << (questions ? "" : questions.error().message);
  std::vector<Entry> entries = sit(questions.value_or(std::vector<Question>()), 2);
  std::ostringstream table;
  write_table(entries, table);
  write_failures(entries, table);
  std::cout << table.str();
  std::ofstream(name + ".txt") << table.str();
  return entries;
}

TEST(ExamOfSheets, NamesWhatHidesAndNothingWhereNothingDoes) {
  Paper paper;
  paper.suites = {"sheet_field"};
  paper.effects = {"nonlinear_stiffness", "poisson_coupling"};
  paper.sizes = {3.0};
  paper.seeds = 1;
  paper.nulls = 1;
  paper.first_seed = 11;
  const std::vector<Entry> entries = sit_and_show(paper, "exam_sheets");
  ASSERT_EQ(entries.size(), 3U);
  for (const Entry& entry : entries) {
    EXPECT_EQ(entry.mark.grade, Grade::right) << entry.question.name();
    const bool hides = entry.question.kind == Kind::effect;
    EXPECT_EQ(entry.mark.certain, hides) << entry.question.name();
  }
}

}  // namespace
}  // namespace tenter::exam
