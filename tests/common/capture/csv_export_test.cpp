// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_export.h"

#include <gtest/gtest.h>

#include <random>

#include "common/capture/csv/csv_import.h"
#include "common/capture/csv/description.h"
#include "common/capture/show.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using test::bytes_of;
using test::import_text;
using test::message_of;

TEST(CsvExport, ImportsAgainToTheSameCapture) {
  const Capture capture = test::small_capture();
  const CsvExport files = export_csv(capture);
  const auto again = import_text(files.csv, files.description);
  ASSERT_TRUE(again) << message_of(again) << "\n" << files.description;
  EXPECT_EQ(bytes_of(*again), bytes_of(capture));
}

TEST(CsvExport, ShippedCapturesComeBackTheSame) {
  const std::string data = TENTER_TEST_DATA "/knit/";
  for (const std::string name :
       {"acrylic_stockinette_y", "cotton_stockinette_x", "acrylic_rib_x", "acrylic_rib_y"}) {
    const auto capture = import_csv(data + name + ".csv", data + name + ".json");
    ASSERT_TRUE(capture) << message_of(capture);
    EXPECT_EQ(capture->runs.size(), 5U);
    EXPECT_GT(capture->frame_count(), 1900U);
    EXPECT_EQ(capture->provenance.licence, "MIT (c) 2023 sabetta");
    const CsvExport files = export_csv(*capture);
    const auto again = import_text(files.csv, files.description);
    ASSERT_TRUE(again) << message_of(again);
    EXPECT_EQ(bytes_of(*again), bytes_of(*capture)) << name;
  }
}

TEST(CsvExport, ExamplesOfTheReadmeAreDescriptions) {
  const std::string readme = test::get_file(TENTER_TEST_DATA "/../../common/capture/README.md");
  int examples = 0;
  const std::string fence = "```json\n";
  for (std::size_t at = readme.find(fence); at != std::string::npos; at = readme.find(fence, at)) {
    at += fence.size();
    const auto description =
        parse_description(readme.substr(at, readme.find("```", at) - at), "README");
    EXPECT_TRUE(description) << message_of(description);
    ++examples;
  }
  EXPECT_EQ(examples, 4);
}

TEST(CsvExport, ShowSaysWhatMatters) {
  const std::string text = show_text(test::small_capture());
  for (const char* part : {"SYNTHETIC", "6 in 2 run(s)", "width 50 mm", "2 runs of group g",
                           "distance of left and right", "missing 1", "sigma per frame"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  Capture timeless = test::small_capture();
  timeless.time_s.clear();
  timeless.protocol.nominal_rate_per_s.reset();
  EXPECT_NE(show_text(timeless).find("AMBIGUOUS"), std::string::npos);
}

/// Damaged input must be refused or taken, never crash; the fuzz is seeded.
TEST(CsvExport, MutatedImportsNeverCrash) {
  const CsvExport files = export_csv(test::small_capture());
  std::mt19937 generator(11);
  const auto mutated = [&](std::string text) {
    const unsigned count = 1 + generator() % 4;
    for (unsigned i = 0; i < count; ++i) {
      const std::size_t at = generator() % text.size();
      switch (generator() % 4) {
        case 0:
          text[at] = static_cast<char>(generator());
          break;
        case 1:
          text.erase(at, 1 + generator() % 20);
          break;
        case 2:
          text.insert(at, 1, "\",\n{}[]:-.e9n"[generator() % 13]);
          break;
        case 3:
          text.insert(at, text.substr(generator() % text.size(), 1 + generator() % 30));
          break;
      }
      if (text.empty()) text = "x";
    }
    return text;
  };
  int refused = 0;
  for (int i = 0; i < 800; ++i) {
    const bool csv = i % 2 == 0;
    const auto capture = import_text(csv ? mutated(files.csv) : files.csv,
                                     csv ? files.description : mutated(files.description));
    if (capture) continue;
    ++refused;
    EXPECT_NE(capture.error().kind, ErrorKind::internal) << capture.error().message;
    EXPECT_GT(capture.error().message.size(), 10U);
  }
  EXPECT_GT(refused, 250);
}

}  // namespace
}  // namespace tenter::capture
