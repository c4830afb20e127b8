// SPDX-License-Identifier: Apache-2.0
#include "common/frames/frames_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "common/h5/reader.h"

namespace tenter::frames {
namespace {

namespace fs = std::filesystem;

std::vector<double> counted(std::size_t count, double from) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = from + static_cast<double>(i);
  return values;
}

/// A square of two triangles in two frames, with one clip, one cord and two terms.
FrameSet two_frames() {
  FrameSet f;
  f.title = "square & co";
  f.scene_json = "{}";
  f.model_json = "{}";
  f.nodes = 4;
  f.material_m = {0, 0, 1, 0, 0, 1, 1, 1};
  f.elements = {{"triangle", 3, {0, 1, 2, 1, 3, 2}}, {"hinge", 4, {1, 2, 0, 3}}};
  f.phases = {"pull"};
  f.clips = {"a"};
  f.cords = {"a.c"};
  f.terms = {"both<", "bend"};
  f.phase = {-1, 0};
  f.phase_share = {1, 0.5};
  f.steps = {1, 2};
  f.iterations = {9, 5};
  f.factorisations = {10, 6};
  f.stability = {0, 1};
  f.net_force_N = {1e-6, 2e-6};
  f.contact_violation_m = {0, 0};
  f.limit_violation = {0, 1e-7};
  f.gravity_factor = {1, 1};
  f.pressure_Pa = {0, 3};
  f.potential_J = {-1, -2};
  f.position_m = counted(24, 100);
  f.clip_position_m = counted(6, 200);
  f.clip_rotation = counted(18, 300);
  f.force_N = counted(6, 400);
  f.torque_N_m = counted(6, 500);
  f.cord_force_N = counted(6, 600);
  f.term_energy_J = counted(4, 700);
  f.strains = {
      {"both<", "green_pair", "triangle", "1", {0.5, 0.25}, {counted(4, 800), counted(4, 850)}},
      {"bend", "bend_u", "hinge", "1/m", {0.1}, {counted(2, 900)}}};
  return f;
}

class FramesFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-frames-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    path_ = (folder_ / "frames.h5").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string content(const std::string& path) {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return bytes.str();
  }

  fs::path folder_;
  std::string path_;
};

TEST_F(FramesFile, HoldsEveryListWithItsUnit) {
  ASSERT_TRUE(write_frames(two_frames(), path_));
  const auto file = h5::H5Reader::open(path_);
  ASSERT_TRUE(file);
  using Shape = std::vector<std::uint64_t>;
  const FrameSet f = two_frames();
  const struct {
    const char* path;
    Shape shape;
    std::vector<double> values;
    const char* unit;
  } lists[] = {
      {"/entry/positions/position", {2, 4, 3}, f.position_m, "m"},
      {"/entry/mesh/material", {4, 2}, f.material_m, "m"},
      {"/entry/mesh/triangle", {2, 3}, {0, 1, 2, 1, 3, 2}, ""},
      {"/entry/mesh/hinge", {1, 4}, {1, 2, 0, 3}, ""},
      {"/entry/reactions/force", {2, 1, 3}, f.force_N, "N"},
      {"/entry/reactions/torque", {2, 1, 3}, f.torque_N_m, "N m"},
      {"/entry/reactions/position", {2, 1, 3}, f.clip_position_m, "m"},
      {"/entry/reactions/rotation", {2, 1, 3, 3}, f.clip_rotation, "1"},
      {"/entry/cords/force", {2, 1, 3}, f.cord_force_N, "N"},
      {"/entry/energies/energy", {2, 2}, f.term_energy_J, "J"},
      {"/entry/energies/potential", {2}, f.potential_J, "J"},
      {"/entry/strains/01_both<_triangle/strain_1", {2, 2}, f.strains[0].values[0], "1"},
      {"/entry/strains/01_both<_triangle/strain_2", {2, 2}, f.strains[0].values[1], "1"},
      {"/entry/frames/000001/01_both<_triangle_2", {2}, {852, 853}, "1"},
      {"/entry/frames/000000/position", {4, 3}, counted(12, 100), "m"},
      {"/entry/strains/01_both<_triangle/share", {2}, f.strains[0].share, "m^2"},
      {"/entry/strains/02_bend_hinge/strain", {2, 1}, f.strains[1].values[0], "1/m"},
      {"/entry/solution/net_force", {2}, f.net_force_N, "N"},
      {"/entry/solution/limit_violation", {2}, f.limit_violation, "1"},
      {"/entry/solution/pressure", {2}, f.pressure_Pa, "Pa"},
      {"/entry/solution/steps", {2}, {1, 2}, ""},
      {"/entry/solution/phase", {2}, {-1, 0}, ""},
  };
  for (const auto& list : lists) {
    const auto table = file->table(list.path);
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ(table->shape, list.shape) << list.path;
    EXPECT_EQ(table->values, list.values) << list.path;
    if (*list.unit == '\0') continue;
    EXPECT_EQ(*file->text_attribute(list.path, "units"), list.unit);
  }
  EXPECT_EQ(*file->texts("/entry/reactions/clip"), std::vector<std::string>{"a"});
  EXPECT_EQ(*file->texts("/entry/energies/term"), (std::vector<std::string>{"both<", "bend"}));
  EXPECT_EQ(*file->text_attribute("/entry", "default"), "reactions");
  EXPECT_EQ(*file->text_attribute("/entry/reactions", "signal"), "force");
}

TEST_F(FramesFile, TheSameFramesAreTheSameBytes) {
  ASSERT_TRUE(write_frames(two_frames(), path_));
  const std::string again = (folder_ / "again.h5").string();
  ASSERT_TRUE(write_frames(two_frames(), again));
  ASSERT_GT(content(path_).size(), 1000U);
  EXPECT_EQ(content(path_), content(again));
}

TEST_F(FramesFile, TheSidecarRefersToWhatIsThere) {
  ASSERT_TRUE(write_frames(two_frames(), path_));
  const std::string side = (folder_ / "frames.xdmf").string();
  ASSERT_TRUE(write_xdmf(path_, side));
  const std::string text = content(side);
  const auto file = h5::H5Reader::open(path_);
  ASSERT_TRUE(file);

  // every reference: the dataset is there, in the shape that is said
  const std::regex item(R"x(<DataItem Dimensions="([\d ]+)" [^>]*>frames.h5:([^<]+)</DataItem>)x");
  int items = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), item), end; at != end; ++at, ++items) {
    const std::string path = std::regex_replace((*at)[2].str(), std::regex("&lt;"), "<");
    const auto shape = file->shape(path);
    ASSERT_TRUE(shape) << shape.error().message;
    std::string said;
    for (const std::uint64_t length : *shape)
      said += (said.empty() ? "" : " ") + std::to_string(length);
    EXPECT_EQ((*at)[1].str(), said) << path;
  }
  EXPECT_EQ(items, 2 * (1 + 1 + 2));  // triangles, positions and two strain components a frame
  const auto times = [&text](const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++count;
    return count;
  };
  EXPECT_EQ(times("<Grid "), 3U);
  EXPECT_EQ(times("</Grid>"), 3U);
  EXPECT_EQ(times("CollectionType=\"Temporal\""), 1U);
  EXPECT_EQ(times("TopologyType=\"Triangle\" NumberOfElements=\"2\""), 2U);
  EXPECT_EQ(times("frames.h5:/entry/mesh/triangle<"), 2U);
  EXPECT_EQ(times("Name=\"both&lt;_2\""), 2U);
}

TEST_F(FramesFile, MixedBodiesAreCollections) {
  FrameSet f = two_frames();
  f.elements = {{"tetrahedron", 4, {0, 1, 2, 3}}, {"hexahedron", 8, {0, 1, 2, 3, 0, 1, 2, 3}}};
  f.strains.clear();
  ASSERT_TRUE(write_frames(f, path_));
  const auto text = xdmf_of(path_);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_NE(text->find("CollectionType=\"Spatial\""), std::string::npos);
  EXPECT_NE(text->find("TopologyType=\"Tetrahedron\" NumberOfElements=\"1\""), std::string::npos);
  EXPECT_NE(text->find("TopologyType=\"Hexahedron\" NumberOfElements=\"1\""), std::string::npos);
}

TEST_F(FramesFile, SaysWhatIsNotOne) {
  EXPECT_FALSE(write_frames(FrameSet{}, path_));
  EXPECT_FALSE(fs::exists(path_));
  std::ofstream(path_) << "words";
  const auto none = xdmf_of(path_);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("is not an HDF5 file"), std::string::npos);
}

}  // namespace
}  // namespace tenter::frames
