// SPDX-License-Identifier: Apache-2.0
#include "common/base/atomic_write.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/base/text_file.h"

namespace tenter {
namespace {

namespace fs = std::filesystem;

class AtomicWrite : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-atomic-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t file_count() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(AtomicWrite, ReplacesAFileAndLeavesNothingElse) {
  const std::string path = folder_ / "a";
  ASSERT_TRUE(write_atomically(path, "one", 3));
  ASSERT_TRUE(write_atomically(path, "second", 6));
  EXPECT_EQ(*read_text_file(path, 100), "second");
  EXPECT_EQ(file_count(), 1U);
}

TEST_F(AtomicWrite, AnUncommittedFileGoesAway) {
  {
    const auto file = AtomicFile::create(folder_ / "a");
    ASSERT_TRUE(file);
    EXPECT_EQ(file_count(), 1U);
  }
  EXPECT_EQ(file_count(), 0U);
}

TEST_F(AtomicWrite, ATargetThatIsAFolderIsRefused) {
  fs::create_directory(folder_ / "a");
  const auto done = write_atomically(folder_ / "a", "x", 1);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(file_count(), 1U);
}

TEST_F(AtomicWrite, ReadingHasALimit) {
  const std::string path = folder_ / "a";
  ASSERT_TRUE(write_atomically(path, "123456", 6));
  EXPECT_EQ(read_text_file(path, 5).error().kind, ErrorKind::bad_input);
  EXPECT_EQ(read_text_file(folder_ / "none", 5).error().kind, ErrorKind::not_found);
  EXPECT_EQ(read_text_file(folder_, 5).error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace tenter
