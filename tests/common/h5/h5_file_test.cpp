// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/h5/reader.h"
#include "common/h5/writer.h"

namespace tenter::h5 {
namespace {

namespace fs = std::filesystem;

class H5File : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-h5-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    path_ = folder_ / "f.h5";
    H5Writer file(path_);
    file.group("/", "NXroot");
    file.group("/g", "NXcollection");
    file.text("/g/text", "words");
    file.text("/g/empty", "");
    file.number("/g/number", 2.5, "m");
    file.integer("/g/integer", -7);
    file.array("/g/reals", std::vector<double>{1, 2, 3}, "N");
    file.array("/g/ints", std::vector<int>{4, 5});
    file.array("/g/texts", std::vector<std::string>{"a", "", "longer"});
    file.array("/g/none", std::vector<double>{}, "");
    file.array("/g/table", std::vector<double>{1, 2, 3, 4, 5, 6}, {3, 1, 2}, "m");
    file.array("/g/whole", std::vector<int>{1, 2, 3, 4, 5, 6}, {2, 3});
    file.attribute("/g", "flag", std::int64_t{1});
    file.attribute("/g", "ratio", 0.25);
    ASSERT_TRUE(std::move(file).save());
  }
  void TearDown() override { fs::remove_all(folder_); }

  template <class T>
  std::string complaint(const Expected<T>& result) const {
    if (result) return "";
    const std::string message = result.error().message;
    return message.substr(message.find(": ") + 2);
  }

  fs::path folder_;
  std::string path_;
};

TEST_F(H5File, HoldsWhatWasPutIn) {
  const auto file = H5Reader::open(path_);
  ASSERT_TRUE(file);
  EXPECT_EQ(*file->text("/g/text"), "words");
  EXPECT_EQ(*file->text("/g/empty"), "");
  EXPECT_EQ(*file->number("/g/number"), 2.5);
  EXPECT_EQ(*file->integer("/g/integer"), -7);
  EXPECT_EQ(*file->doubles("/g/reals"), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(*file->ints("/g/ints"), (std::vector<int>{4, 5}));
  EXPECT_EQ(*file->texts("/g/texts"), (std::vector<std::string>{"a", "", "longer"}));
  EXPECT_TRUE(file->doubles("/g/none")->empty());
  EXPECT_EQ(*file->integer_attribute("/g", "flag"), 1);
  EXPECT_EQ(*file->number_attribute("/g", "ratio"), 0.25);
  EXPECT_EQ(*file->text_attribute("/g/reals", "units"), "N");
  EXPECT_TRUE(*file->has("/g/reals"));
  EXPECT_FALSE(*file->has("/g/unreal"));
  EXPECT_FALSE(*file->has("/x/y"));
  EXPECT_TRUE(*file->has_attribute("/g", "flag"));
  EXPECT_FALSE(*file->has_attribute("/g", "flags"));
  EXPECT_EQ(file->members("/g")->size(), 10U);
}

TEST_F(H5File, TablesKeepTheirShape) {
  const auto file = H5Reader::open(path_);
  ASSERT_TRUE(file);
  using Shape = std::vector<std::uint64_t>;
  const auto table = file->table("/g/table");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->shape, (Shape{3, 1, 2}));
  EXPECT_EQ(table->values, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(*file->text_attribute("/g/table", "units"), "m");
  EXPECT_EQ(*file->shape("/g/whole"), (Shape{2, 3}));
  EXPECT_EQ(file->table("/g/whole")->values, table->values);
  EXPECT_EQ(file->table("/g/reals")->shape, Shape{3});
  EXPECT_EQ(complaint(file->doubles("/g/table")), "/g/table: must be a one-dimensional list.");
  EXPECT_EQ(complaint(file->table("/g/number")), "/g/number: must be a list of 1 to 4 dimensions.");
  EXPECT_EQ(complaint(file->shape("/g")), "/g: must be a dataset.");
}

TEST_F(H5File, TablesLargerThanAChunkComeBackWhole) {
  std::vector<double> values(3UL * 50000 * 3);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i % 977);
  H5Writer large(path_);
  large.array("/x", values, {3, 50000, 3}, "m");
  ASSERT_TRUE(std::move(large).save());
  const auto file = H5Reader::open(path_);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->table("/x")->values, values);
}

TEST_F(H5File, AShapeThatDoesNotHoldTheValuesIsRefused) {
  H5Writer wrong(path_);
  wrong.array("/x", std::vector<double>{1, 2, 3}, {2, 2}, "m");
  EXPECT_FALSE(std::move(wrong).save());
}

TEST_F(H5File, NamesWhatIsWrong) {
  const auto file = H5Reader::open(path_);
  ASSERT_TRUE(file);
  EXPECT_EQ(complaint(file->text("/g/absent")), "/g/absent: is missing.");
  EXPECT_EQ(complaint(file->text("/x/absent")), "/x/absent: is missing.");
  EXPECT_EQ(complaint(file->text("/g")), "/g: must be a dataset.");
  EXPECT_EQ(complaint(file->text("/g/number")), "/g/number: must hold text of fixed length.");
  EXPECT_EQ(complaint(file->doubles("/g/texts")), "/g/texts: must hold numbers.");
  EXPECT_EQ(complaint(file->ints("/g/reals")), "/g/reals: must hold whole numbers.");
  EXPECT_EQ(complaint(file->doubles("/g/number")), "/g/number: must be a one-dimensional list.");
  EXPECT_EQ(complaint(file->number("/g/reals")), "/g/reals: must be a single value.");
  EXPECT_EQ(complaint(file->text_attribute("/g", "none")), "/g@none: is missing.");
  EXPECT_EQ(complaint(file->members("/g/reals")), "/g/reals: must be a group.");
}

TEST_F(H5File, LimitsHold) {
  const auto file = H5Reader::open(path_, {.dataset_bytes = 16, .text_bytes = 4, .members = 3});
  ASSERT_TRUE(file);
  EXPECT_EQ(complaint(file->doubles("/g/reals")),
            "/g/reals: claims 3 values, more than the limit of 16 bytes.");
  EXPECT_EQ(complaint(file->text("/g/text")), "/g/text: claims texts of 5 bytes each.");
  EXPECT_EQ(complaint(file->members("/g")), "/g: has too many members.");
}

}  // namespace
}  // namespace tenter::h5
