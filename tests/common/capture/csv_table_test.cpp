// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_table.h"

#include <gtest/gtest.h>

namespace tenter::capture {
namespace {

Expected<CsvTable> parse(const std::string& text, const CsvOptions& options = {}) {
  return parse_csv(text, options, "t.csv");
}

TEST(CsvTable, ReadsQuotesBlanksLineEndsAndTheUtf8Mark) {
  const auto table = parse("\xEF\xBB\xBF a , \"b, \"\"c\"\"\"\r\n1,\" two \"\r\n\r\n  3,4");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->header, (std::vector<std::string>{"a", "b, \"c\""}));
  ASSERT_EQ(table->row_count(), 2U);
  EXPECT_EQ(table->cell(0, 1), " two ");
  EXPECT_EQ(table->cell(1, 0), "3");
  EXPECT_EQ(table->lines, (std::vector<std::size_t>{2, 4}));
  EXPECT_EQ(table->find("a"), 0U);
  EXPECT_EQ(table->find("z"), 2U);
}

TEST(CsvTable, CountsLinesInsideQuotes) {
  const auto table = parse("a,b\n\"x\ny\",1\n2,3\n");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->cell(0, 0), "x\ny");
  EXPECT_EQ(table->lines, (std::vector<std::size_t>{2, 4}));
}

TEST(CsvTable, SkipsAPreambleAndTakesOtherSeparators) {
  const auto table = parse("Machine 7;;\nserial\na;b\n1;2\n", {.separator = ';', .skip_lines = 2});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->header.size(), 2U);
  EXPECT_EQ(table->lines[0], 4U);
}

TEST(CsvTable, NamesTheLineOfWhatItRefuses) {
  const auto message = [](const std::string& text) {
    const auto table = parse(text);
    return table ? std::string("accepted") : table.error().message;
  };
  EXPECT_EQ(message("a,b\n1,2\n1,2,3\n"), "t.csv: line 3 has 3 cells where the header has 2.");
  EXPECT_EQ(message("a,b\n1,\"2\n"), "t.csv: line 2 opens a quote that is never closed.");
  EXPECT_EQ(message("a,b\n1,\"2\"x\n"), "t.csv: line 2 has text after a closing quote.");
  EXPECT_EQ(message("a,b\n1,2\"x\n"), "t.csv: line 2 has a quote in the middle of a cell.");
  EXPECT_EQ(message("a,a\n"), "t.csv: line 1: the header names column \"a\" twice.");
  EXPECT_EQ(message("a,\n"), "t.csv: line 1: column 2 of the header has no name.");
  EXPECT_EQ(message(""), "t.csv: has no header line.");
  EXPECT_EQ(message(std::string("a,b\n1,\0\n", 8)),
            "t.csv: line 2 holds a zero byte; this is not a text file.");
}

TEST(CsvTable, QuotesWhatMustBeQuoted) {
  for (const std::string text : {"plain", "", " lead", "a,b", "a\"b", "a\nb"}) {
    const auto table = parse("x,y\n" + csv_cell(text) + ",1\n");
    ASSERT_TRUE(table) << text;
    EXPECT_EQ(table->cell(0, 0), text);
  }
}

}  // namespace
}  // namespace tenter::capture
