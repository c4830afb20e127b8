// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/vertex_residuals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/report/residual_file.h"

namespace tenter::report {
namespace {

namespace fs = std::filesystem;

class VertexResidualFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-vertices-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    path_ = (folder_ / "residuals.h5").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  static VertexResiduals block(char digit, int frames, int vertices) {
    VertexResiduals b;
    b.capture_id = std::string(64, digit);
    b.capture_title = std::string("pull ") + digit;
    for (int f = 0; f < frames; ++f) b.frame.push_back(10 + f);
    for (int v = 0; v < vertices; ++v) {
      b.vertex.push_back(3 * v);
      b.sigma_m.push_back(7.5e-5);
      b.material_m.insert(b.material_m.end(), {0.01 * v, 0.02});
    }
    for (int i = 0; i < 3 * frames * vertices; ++i) {
      b.measured_m.push_back(1e-3 * i);
      b.start_m.push_back(2e-3 * i);
      b.fitted_m.push_back(1e-3 * i + 1e-4);
    }
    b.measured_m[5] = std::nan("");
    return b;
  }
  std::string bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  fs::path folder_;
  std::string path_;
};

TEST_F(VertexResidualFile, ReadsWhatItWroteAndEqualBlocksAreEqualBytes) {
  const std::vector<VertexResiduals> blocks = {block('a', 4, 5), block('b', 2, 3)};
  ASSERT_TRUE(write_residuals({}, path_, blocks));
  const std::string first = bytes();
  ASSERT_TRUE(write_residuals({}, path_, blocks));
  EXPECT_EQ(bytes(), first);
  const auto read = read_vertex_residuals_guarded(path_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].capture_title, "pull a");
  EXPECT_EQ((*read)[0].frame, blocks[0].frame);
  EXPECT_EQ((*read)[1].vertex, blocks[1].vertex);
  EXPECT_EQ((*read)[1].start_m, blocks[1].start_m);
  EXPECT_EQ((*read)[0].material_m, blocks[0].material_m);
  EXPECT_TRUE(std::isnan((*read)[0].measured_m[5]));
  // two coordinates of the vertex were seen, each off by 0.1 mm
  EXPECT_NEAR((*read)[0].residual_m(0, 1), std::sqrt(2.0) * 1e-4, 1e-12);
  EXPECT_NEAR((*read)[0].residual_m(0, 2), std::sqrt(3.0) * 1e-4, 1e-12);
  EXPECT_TRUE(read_residuals(path_)->empty());
}

TEST_F(VertexResidualFile, FiltersByCaptureFramesAndVertices) {
  ASSERT_TRUE(write_residuals({}, path_, {block('a', 4, 5), block('b', 2, 3)}));
  const auto only = [&](const VertexFilter& filter) {
    return read_vertex_residuals(path_, filter).value();
  };
  EXPECT_EQ(only({.capture = "bbbbbb"}).size(), 1U);
  EXPECT_EQ(only({.capture = "bbb"}).size(), 0U);
  EXPECT_EQ(only({.capture = "pull a"}).size(), 1U);
  EXPECT_EQ(only({.first_frame = 12}).size(), 1U);
  EXPECT_EQ(only({.last_frame = 9}).size(), 0U);
  const auto some =
      only({.first_frame = 11, .last_frame = 11, .first_vertex = 6, .last_vertex = 9});
  ASSERT_EQ(some.size(), 2U);
  EXPECT_EQ(some[0].vertex, (std::vector<int>{6, 9}));
  const VertexResiduals whole = block('a', 4, 5);
  EXPECT_EQ(some[0].fitted_m[0], whole.fitted_m[whole.at(1, 2)]);
  EXPECT_EQ(some[1].vertex, (std::vector<int>{6}));
}

TEST_F(VertexResidualFile, WhatDoesNotFitIsRefused) {
  VertexResiduals odd = block('a', 2, 2);
  odd.fitted_m.pop_back();
  EXPECT_EQ(write_residuals({}, path_, {odd}).error().kind, ErrorKind::internal);
  EXPECT_EQ(read_vertex_residuals(path_).error().kind, ErrorKind::not_found);
  h5::H5Writer file(path_);
  file.group("/", "NXroot");
  file.attribute("/", "schema", std::string("tenter.residuals"));
  file.attribute("/", "version", std::int64_t{1});
  file.group("/entry", "NXentry");
  VertexResiduals fewer = block('a', 2, 2);
  ASSERT_TRUE(write_vertex_blocks(file, {fewer}));
  file.group("/entry/vertices_0001", "NXdata");
  file.attribute("/entry/vertices_0001", "capture_id", std::string("a"));
  file.attribute("/entry/vertices_0001", "capture_title", std::string("a"));
  file.array("/entry/vertices_0001/frame", std::vector<int>{1, 2});
  file.array("/entry/vertices_0001/vertex", std::vector<int>{1});
  file.array("/entry/vertices_0001/material", std::vector<double>{1, 2, 3, 4}, {2, 2}, "m");
  ASSERT_TRUE(std::move(file).save());
  EXPECT_NE(read_vertex_residuals(path_).error().message.find("vertices_0001/material"),
            std::string::npos);
}

}  // namespace
}  // namespace tenter::report
