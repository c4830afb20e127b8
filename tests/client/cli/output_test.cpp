// SPDX-License-Identifier: Apache-2.0
#include "client/cli/output.h"

#include <gtest/gtest.h>

namespace tenter::cli {
namespace {

TEST(Output, TablesLineUpAndDropControlCharacters) {
  Table table({"name", ">count"});
  table.add({"wool", "7"});
  table.add({"\x1b[31mk\u00fcper", "12345"});
  EXPECT_EQ(table.text(),
            "name       count\n"
            "wool           7\n"
            "[31mk\u00fcper  12345\n");
}

TEST(Output, WordsForBytesAndSeconds) {
  EXPECT_EQ(bytes_words(0), "0 B");
  EXPECT_EQ(bytes_words(1400), "1.4 kB");
  EXPECT_EQ(bytes_words(200e6), "200 MB");
  EXPECT_EQ(bytes_words(999.6e6), "1.0 GB");
  EXPECT_EQ(seconds_words(0.42), "0.4 s");
  EXPECT_EQ(seconds_words(12.3), "12 s");
  EXPECT_EQ(seconds_words(200), "3 min 20 s");
  EXPECT_EQ(seconds_words(7260), "2 h 1 min");
  EXPECT_EQ(seconds_words(-1), "0.0 s");
  EXPECT_EQ(seconds_words(1e300), seconds_words(3e9));
}

TEST(Output, ErrorsCarryTheExitCode) {
  const Json value = error_json({ErrorKind::job_failed, "no"});
  EXPECT_EQ(value["error"]["code"], 7);
  EXPECT_EQ(value["error"]["kind"], "job_failed");
}

TEST(Output, CellsTakeAnyValue) {
  const Json object = {
      {"text", "a"}, {"number", 1.5}, {"none", nullptr}, {"flag", true}, {"list", {1, 2}}};
  EXPECT_EQ(cell(object, "text"), "a");
  EXPECT_EQ(cell(object, "number"), "1.5");
  EXPECT_EQ(cell(object, "none"), "-");
  EXPECT_EQ(cell(object, "absent"), "-");
  EXPECT_EQ(cell(object, "flag"), "yes");
  EXPECT_EQ(cell(object, "list"), "[1,2]");
  EXPECT_EQ(cell(Json(3), "x"), "-");
  EXPECT_EQ(clock_words(object, "absent"), "");
}

}  // namespace
}  // namespace tenter::cli
