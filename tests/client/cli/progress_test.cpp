// SPDX-License-Identifier: Apache-2.0
#include "client/cli/progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace tenter::cli {
namespace {

using client::JobState;
using client::JobUpdate;

JobUpdate running(const std::string& stage, double fraction, double elapsed_s) {
  JobUpdate update;
  update.job_id = "17";
  update.state = JobState::running;
  update.attempt = 1;
  update.stage = stage;
  update.iteration = 12;
  update.cost = 0.0123;
  update.fraction = fraction;
  update.elapsed_s = elapsed_s;
  return update;
}

TEST(JobLine, SaysStageIterationCostAndTimeLeft) {
  const std::string line = job_line(running("refit", 0.25, 10.0), 200);
  for (const char* words : {"job 17", "running", "refit", "iteration 12", "cost 0.0123", "[####",
                            "25 %", "10 s, about 30 s left"})
    EXPECT_NE(line.find(words), std::string::npos) << words << " in " << line;
  EXPECT_LE(job_line(running("refit", 0.25, 10.0), 40).size(), 40u);
  const std::string narrow = job_line(running("refit", 0.25, 10.0), 79);
  EXPECT_LE(narrow.size(), 79u);
  EXPECT_NE(narrow.find("about 30 s left"), std::string::npos) << narrow;
}

TEST(JobLine, ValuesThatHaveNoRoomStandBelowIt) {
  JobUpdate update = running("shear", 0.25, 10.0);
  update.detail =
      "frame 3 of 12, shear; weft 1446 139 \u2581\u2583\u2588, warp 121.4 96.5, shear 37.99";
  EXPECT_TRUE(detail_lines(update, 200).empty());
  EXPECT_NE(job_line(update, 200).find("\u2583"), std::string::npos);
  EXPECT_EQ(job_line(update, 79).find("weft"), std::string::npos);
  const auto lines = detail_lines(update, 44);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "    frame 3 of 12, shear; weft 1446 139 \u2581\u2583\u2588,");
  EXPECT_EQ(lines[1], "    warp 121.4 96.5, shear 37.99");
  update.detail = "";
  for (int i = 0; i < 400; ++i) update.detail += "value,";
  EXPECT_EQ(detail_lines(update, 60).size(), kDetailLines);
  // drawn again from the same place, and all cleared in the end
  std::ostringstream out;
  ProgressDisplay display(out, true, 60);
  display.show(update);
  display.finish();
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
  EXPECT_NE(text.find("\x1b[5A"), std::string::npos);
  EXPECT_EQ(text.substr(text.size() - 4), "\r\x1b[J");
}

TEST(JobLine, DoesNotClaimWhatIsNotKnown) {
  JobUpdate update = running("read", -1.0, 0.2);
  update.iteration = -1;
  const std::string line = job_line(update, 200);
  EXPECT_EQ(line.find("iteration"), std::string::npos);
  EXPECT_EQ(line.find('%'), std::string::npos);
  EXPECT_EQ(line.find("left"), std::string::npos);
  update.link = client::Link::lost;
  EXPECT_NE(job_line(update, 200).find("silent"), std::string::npos);
  update.state = JobState::failed;
  update.message = "\x1b[2Jhello";
  EXPECT_EQ(job_line(update, 200).find('\x1b'), std::string::npos);
}

TEST(ProgressDisplay, ATerminalGetsOneLineDrawnAgain) {
  std::ostringstream out;
  ProgressDisplay display(out, true, 80);
  const auto start = ProgressDisplay::Clock::now();
  for (int i = 0; i < 100; ++i)
    display.show(running("fit", i / 100.0, i * 0.01), start + std::chrono::milliseconds(10 * i));
  display.finish();
  const std::string text = out.str();
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const auto redraws = std::count(text.begin(), text.end(), '\r');
  EXPECT_GE(redraws, 9);
  EXPECT_LE(redraws, 13);  // ten a second, and the last that clears
  EXPECT_EQ(text.substr(text.size() - 4), "\r\x1b[K");
}

TEST(ProgressDisplay, ElsewhereLinesComeWithNewsOrEveryTenSeconds) {
  std::ostringstream out;
  ProgressDisplay display(out, false, 80);
  const auto start = ProgressDisplay::Clock::now();
  for (int i = 0; i < 250; ++i)
    display.show(running(i < 120 ? "screen" : "refit", i / 250.0, i * 0.1),
                 start + std::chrono::milliseconds(100 * i));
  display.finish();
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);  // 0 s, 10 s, refit at 12 s, 22 s
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

TEST(ProgressDisplay, TransfersShowBytesRateAndWhatWasThere) {
  std::ostringstream out;
  ProgressDisplay display(out, true, 120);
  const auto start = ProgressDisplay::Clock::now();
  display.show_transfer("sending pull.h5", {50'000'000, 200'000'000, 50'000'000}, start);
  display.show_transfer("sending pull.h5", {150'000'000, 200'000'000, 50'000'000},
                        start + std::chrono::seconds(1));
  display.show_transfer("sending pull.h5", {200'000'000, 200'000'000, 50'000'000, true},
                        start + std::chrono::seconds(2));
  for (const char* words : {"sending pull.h5", "75 %", "150 MB of 200 MB", "50 MB were there",
                            "100 MB/s", "stored; the server reads them"})
    EXPECT_NE(out.str().find(words), std::string::npos) << words << " in " << out.str();
}

TEST(ProgressDisplay, AShortTransferIsNotWorthALineOffTheTerminal) {
  std::ostringstream out;
  ProgressDisplay display(out, false, 120);
  const auto start = ProgressDisplay::Clock::now();
  display.show_transfer("sending pull.h5", {0, 1000, 0}, start);
  display.show_transfer("sending pull.h5", {1000, 1000, 0}, start + std::chrono::seconds(2));
  EXPECT_EQ(out.str(), "");
  display.show_transfer("sending more.h5", {0, 1000, 0}, start + std::chrono::seconds(3));
  display.show_transfer("sending more.h5", {500, 1000, 0}, start + std::chrono::seconds(14));
  EXPECT_NE(out.str().find("50 %"), std::string::npos);
}

}  // namespace
}  // namespace tenter::cli
