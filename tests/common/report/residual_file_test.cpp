// SPDX-License-Identifier: Apache-2.0
#include "common/report/residual_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace tenter::report {
namespace {

namespace fs = std::filesystem;

class ResidualFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-residuals-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    path_ = folder_ / "residuals.h5";
  }
  void TearDown() override { fs::remove_all(folder_); }

  static ResidualTable table(const std::string& id, const std::string& channel, int rows) {
    ResidualTable t;
    t.capture_id = id;
    t.capture_title = "capture " + id.substr(0, 2);
    t.channel = channel;
    t.unit = "N/m";
    for (int i = 0; i < rows; ++i) {
      t.frame.push_back(10 * i + 1);
      t.run.push_back(2);
      t.block.push_back(i / 4);
      t.branch.push_back(i % 4);
      t.time_s.push_back(0.5 * i);
      t.strain_x.push_back(0.01 * i);
      t.strain_y.push_back(std::nan(""));
      t.strain_xy.push_back(0.0);
      t.measured.push_back(3.0 * i);
      t.predicted_baseline.push_back(2.5 * i);
      t.predicted_extended.push_back(2.9 * i);
      t.sigma.push_back(0.1);
      t.weight.push_back(1.0);
    }
    return t;
  }
  std::string bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  const std::string a_ = std::string(64, 'a');
  const std::string b_ = std::string(64, 'b');
  fs::path folder_;
  std::string path_;
};

TEST_F(ResidualFile, ReadsWhatItWroteAndEqualTablesAreEqualBytes) {
  const std::vector<ResidualTable> tables = {table(a_, "force", 9), table(b_, "stress_y", 3)};
  ASSERT_TRUE(write_residuals(tables, path_));
  const std::string first = bytes();
  ASSERT_TRUE(write_residuals(tables, path_));
  EXPECT_EQ(bytes(), first);
  const auto read = read_residuals_guarded(path_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].capture_title, "capture aa");
  EXPECT_EQ((*read)[0].unit, "N/m");
  EXPECT_EQ((*read)[0].predicted_extended, tables[0].predicted_extended);
  EXPECT_EQ((*read)[0].time_s, tables[0].time_s);
  EXPECT_TRUE(std::isnan((*read)[1].strain_y[2]));
  EXPECT_EQ((*read)[1].branch, (std::vector<int>{0, 1, 2}));
}

TEST_F(ResidualFile, FiltersByCaptureChannelBlockAndFrames) {
  ASSERT_TRUE(write_residuals({table(a_, "force", 9), table(b_, "stress_y", 9)}, path_));
  const auto rows = [&](const ResidualFilter& filter) {
    const auto read = read_residuals(path_, filter);
    EXPECT_TRUE(read);
    std::size_t count = 0;
    for (const ResidualTable& t : *read) count += t.size();
    return count;
  };
  EXPECT_EQ(rows({}), 18U);
  EXPECT_EQ(rows({.channel = "force"}), 9U);
  EXPECT_EQ(rows({.capture = b_}), 9U);
  EXPECT_EQ(rows({.capture = "bbbbbb"}), 9U);
  EXPECT_EQ(rows({.capture = "bbb"}), 0U);
  EXPECT_EQ(rows({.capture = "capture aa"}), 9U);
  EXPECT_EQ(rows({.channel = "none"}), 0U);
  EXPECT_EQ(rows({.block = 2}), 2U);
  EXPECT_EQ(rows({.channel = "force", .first_frame = 11, .last_frame = 31}), 3U);
  const auto read = read_residuals(path_, {.channel = "force", .first_frame = 81});
  ASSERT_EQ(read->size(), 1U);
  EXPECT_EQ(read->front().measured, (std::vector<double>{24.0}));
  EXPECT_EQ(read->front().time_s, (std::vector<double>{4.0}));
}

TEST_F(ResidualFile, TimeMayBeMissingAndNothingMayBeShort) {
  ResidualTable t = table(a_, "force", 4);
  t.time_s.clear();
  ASSERT_TRUE(write_residuals({t}, path_));
  EXPECT_TRUE(read_residuals(path_)->front().time_s.empty());
  ASSERT_TRUE(write_residuals({}, path_));
  EXPECT_TRUE(read_residuals(path_)->empty());
  t.weight.pop_back();
  EXPECT_FALSE(write_residuals({t}, path_));
  EXPECT_TRUE(read_residuals(path_)->empty());
}

TEST_F(ResidualFile, OtherFilesAreRefused) {
  EXPECT_EQ(read_residuals(path_).error().kind, ErrorKind::not_found);
  std::ofstream(path_) << "text";
  EXPECT_EQ(read_residuals_guarded(path_).error().message,
            path_ + ": is not an HDF5 file (or is truncated at its start).");
}

TEST(ResidualWords, NameBranches) {
  EXPECT_EQ(branch_word(0), "load");
  EXPECT_EQ(branch_word(2), "hold");
  EXPECT_EQ(branch_word(9), "other");
}

}  // namespace
}  // namespace tenter::report
