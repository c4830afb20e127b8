// SPDX-License-Identifier: GPL-3.0-or-later
// Captures of a sheet that want to hurt whoever reads them: sizes that lie, versions that do not
// fit, corners that point outside, bytes changed at random.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "common/capture/sheet/sheet_export.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "common/capture/validate.h"
#include "tests/common/capture/sheet/support.h"
#include "tests/common/capture/support.h"
#include "tests/fault/mutated.h"
#include "tests/fault/spoilt_capture.h"

namespace tenter::capture {
namespace {

using fault::mutated;
using fault::said_of;
using test::bytes_of;
using test::put_file;
using test::small_capture;
using test::small_sheet_capture;
using test::TempFolder;

/// Replaces a dataset by one of this shape of which nothing is stored.
void claim(hid_t file, const char* path, const std::vector<hsize_t>& shape, const char* unit,
           hid_t type = H5T_IEEE_F64LE) {
  H5Ldelete(file, path, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  std::vector<hsize_t> chunk(shape);
  for (hsize_t& length : chunk) length = length < 64 ? length : 64;
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  const hid_t data = H5Dcreate2(file, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  EXPECT_GE(data, 0);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, 3);
  const hid_t scalar = H5Screate(H5S_SCALAR);
  const hid_t attribute = H5Acreate2(data, "units", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
  const char bytes[3] = {unit[0], unit[0] ? unit[1] : '\0', '\0'};
  H5Awrite(attribute, text, bytes);
  H5Aclose(attribute);
  H5Sclose(scalar);
  H5Tclose(text);
  H5Dclose(data);
  H5Pclose(properties);
  H5Sclose(space);
}

TEST(HostileSheets, SizesAreHeldAgainstTheFramesBeforeMemoryIsTaken) {
  const std::string mesh = "/entry/meshes/front/";
  EXPECT_EQ(said_of(small_sheet_capture(),
                    [](hid_t f) {
                      claim(f, "/entry/meshes/front/position", {4, 1000000000, 3}, "m");
                    }),
            mesh + "position: has the shape [4 x 1000000000 x 3] where [4 x 9 x any] is needed.");
  EXPECT_NE(said_of(small_sheet_capture(),
                    [](hid_t f) {
                      claim(f, "/entry/meshes/front/position", {4, 9, 1U << 30}, "m");
                    })
                .find("position: claims 38654705664 values, more than the limit of"),
            std::string::npos);
  EXPECT_EQ(said_of(small_sheet_capture(),
                    [](hid_t f) {
                      claim(f, "/entry/clips/moved/rotation", {40000, 4}, "1");
                    }),
            "/entry/clips/moved/rotation: has the shape [40000 x 4] where [4 x 4] is needed.");
  EXPECT_EQ(said_of(small_sheet_capture(),
                    [](hid_t f) { claim(f, "/entry/cords/pull/direction", {4}, "1"); }),
            "/entry/cords/pull/direction: has the shape [4] where [4 x 3] is needed.");
  // where any length will do, what is stored decides
  const std::string message = said_of(small_sheet_capture(), [](hid_t f) {
    claim(f, "/entry/meshes/front/material", {50000000, 2}, "m");
  });
  EXPECT_TRUE(message.starts_with(mesh + "material: claims 800 MB but the file of ")) << message;
  EXPECT_NE(
      said_of(small_sheet_capture(),
              [](hid_t f) {
                claim(f, "/entry/meshes/front/connectivity", {100000000, 3}, "", H5T_STD_I32LE);
              })
          .find("connectivity: claims"),
      std::string::npos);
}

TEST(HostileSheets, WhatIsMissingOrOfAnotherVersion) {
  EXPECT_EQ(said_of(small_sheet_capture(),
                    [](hid_t f) { H5Ldelete(f, "/entry/clips/fixed/rotation", H5P_DEFAULT); }),
            "/entry/clips/fixed/rotation: is missing.");
  EXPECT_EQ(said_of(small_sheet_capture(),
                    [](hid_t f) { H5Ldelete(f, "/entry/meshes/front", H5P_DEFAULT); }),
            "/entry/meshes: must hold one mesh, not 0.");
  EXPECT_EQ(
      said_of(small_sheet_capture(), [](hid_t f) { H5Ldelete(f, "/entry/gravity", H5P_DEFAULT); }),
      "/entry/gravity: is missing.");
  const auto set_version = [](std::int64_t version) {
    return [version](hid_t f) {
      const hid_t attribute = H5Aopen(f, "version", H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_INT64, &version);
      H5Aclose(attribute);
    };
  };
  EXPECT_EQ(said_of(small_sheet_capture(), set_version(3)),
            "/: has version 3 of the layout; this program reads 1 and 2.");
  EXPECT_EQ(said_of(small_sheet_capture(), set_version(1)),
            "a capture of kind \"deforming_sheet\" needs a sheet.");
  EXPECT_EQ(said_of(small_capture(), set_version(2)), "/entry/meshes: is missing.");
}

TEST(HostileSheets, CornersThatPointOutside) {
  const auto write_corner = [](int corner) {
    return [corner](hid_t f) {
      const hid_t data = H5Dopen2(f, "/entry/meshes/front/connectivity", H5P_DEFAULT);
      std::vector<int> corners(24);
      H5Dread(data, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, corners.data());
      corners[5] = corner;
      H5Dwrite(data, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, corners.data());
      H5Dclose(data);
    };
  };
  EXPECT_EQ(said_of(small_sheet_capture(), write_corner(9)), "triangle 1 names vertex 9 of 9.");
  EXPECT_EQ(said_of(small_sheet_capture(), write_corner(-7)), "triangle 1 names vertex -7 of 9.");
}

/// Characters changed to others that tables and descriptions are made of.
std::string misspelt(std::string text, std::mt19937& generator) {
  static constexpr std::string_view kSigns = "0123456789-+.,e\"{}[]:\n ab";
  const unsigned count = 1 + generator() % 3;
  for (unsigned i = 0; i < count; ++i)
    text[generator() % text.size()] = kSigns[generator() % kSigns.size()];
  if (generator() % 8 == 0) text.resize(1 + generator() % text.size());
  return text;
}

TEST(HostileSheets, MisspeltTablesAreRefusedOrMakeSense) {
  const TempFolder folder;
  const auto files = sheet_files(small_sheet_capture(), "c");
  for (const ExportedFile& file : files) put_file(folder.path(file.name), file.text);
  std::mt19937 generator(29);
  int refused = 0;
  for (int i = 0; i < 150; ++i) {
    const ExportedFile& spoilt = files[generator() % files.size()];
    put_file(folder.path(spoilt.name), misspelt(spoilt.text, generator));
    const auto capture = import_sheet(folder.path("c.json"));
    put_file(folder.path(spoilt.name), spoilt.text);
    if (capture) {
      EXPECT_TRUE(validate(*capture)) << spoilt.name;
      continue;
    }
    ++refused;
    const std::string& message = capture.error().message;
    EXPECT_TRUE(message.starts_with(folder.folder())) << message;
    EXPECT_TRUE(message.ends_with(".")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  std::printf("150 misspelt tables: %d refused\n", refused);
  EXPECT_GT(refused, 50);
  EXPECT_TRUE(import_sheet(folder.path("c.json")));
}

TEST(HostileSheets, MutatedFilesAreRefusedOrEqual) {
  const TempFolder folder;
  const std::string path = folder.path("c.h5");
  const std::string good = bytes_of(small_sheet_capture());
  std::mt19937 generator(23);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    put_file(path, mutated(good, generator));
    const auto capture = read_capture_guarded(path);
    if (!capture) {
      ++refused;
      EXPECT_EQ(capture.error().kind, ErrorKind::bad_input) << capture.error().message;
      continue;
    }
    EXPECT_TRUE(bytes_of(*capture) == good) << "mutation " << i << " changed the content unseen";
  }
  std::printf("60 mutated sheets: %d refused\n", refused);
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace tenter::capture
