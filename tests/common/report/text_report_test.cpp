// SPDX-License-Identifier: Apache-2.0
#include "common/report/text_report.h"

#include <gtest/gtest.h>

#include <sstream>

#include "common/report/words.h"
#include "tests/common/report/fixture_result.h"

namespace tenter::report {
namespace {

TEST(TextReport, SaysTheVerdictsAndTheErrors) {
  const std::string text = render_text(fixture::result().dump()).value();
  for (const char* words :
       {"Cause found: nonlinear stiffness.", "Diagnosis of 3 captures with stvk_orthotropic",
        "NAMED", "AMBIGUOUS", "Could also be viscosity", "Next capture: two rates and a hold",
        "p < 0.001", "[SYNTHETIC]", "WARNING", "One rate only",
        "NOT EXCITED   These captures cannot show plastic set or force-camera delay."})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_NE(render_text(fixture::result().dump(), {90, true}).value().find("\x1b["),
            std::string::npos);
}

TEST(TextReport, StaysWithinTheWidth) {
  std::istringstream lines(render_text(fixture::result().dump(), {100, false}).value());
  for (std::string line; std::getline(lines, line);) EXPECT_LE(columns(line), 112u) << line;
}

TEST(TextReport, TerminalEscapesOfTheDocumentDoNotReachTheTerminal) {
  nlohmann::ordered_json result = fixture::result();
  const std::string attack =
      "\x1b]0;owned\x07\x1b[2J\xc2\x9b"
      "31mtext";
  result["captures"][0]["title"] = attack;
  result["verdicts"][0]["words"] = attack;
  result["verdicts"][0]["effect"] = attack;
  const std::string text = render_text(result.dump()).value();
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find('\x07'), std::string::npos);
  EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos);
  EXPECT_NE(text.find("text"), std::string::npos);
}

TEST(Words, NumbersReadWell) {
  EXPECT_EQ(percent(0.1823), "18.2\u202f%");
  EXPECT_EQ(percent(0.0412), "4.1\u202f%");
  EXPECT_EQ(percent(0.0008), "0.08\u202f%");
  EXPECT_EQ(percent(1.0), "100\u202f%");
  EXPECT_EQ(percent({}), "\u2013");
  EXPECT_EQ(p_value(0.0004), "p < 0.001");
  EXPECT_EQ(p_value(0.0131), "p = 0.013");
  EXPECT_EQ(p_value({}), "");
  EXPECT_EQ(significant(0.012345), "0.01235");
  EXPECT_EQ(joined({"a", "b", "c"}), "a, b and c");
  EXPECT_EQ(joined({"a", "b"}, "or"), "a or b");
  EXPECT_EQ(effect_words("poisson_coupling"), "Poisson coupling");
  EXPECT_EQ(effect_words("load_cell_offset"), "load cell offset");
}

}  // namespace
}  // namespace tenter::report
