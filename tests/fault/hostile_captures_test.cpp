// SPDX-License-Identifier: GPL-3.0-or-later
// Files that want to hurt whoever reads them: truncated, flipped, lying about their size, of wrong
// types, leading elsewhere. The reader's process never crashes, and what is accepted is what was
// written.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <random>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "common/h5/reader.h"
#include "common/h5/writer.h"
#include "common/report/residual_file.h"
#include "tests/common/capture/support.h"
#include "tests/fault/mutated.h"
#include "tests/fault/spoilt_capture.h"

namespace tenter::capture {
namespace {

using fault::mutated;
using fault::said_of;
using test::bytes_of;
using test::get_file;
using test::message_of;
using test::put_file;
using test::small_capture;
using test::TempFolder;

/// Replaces a dataset by one of `length` values of which nothing is stored; chunk 0: not chunked.
void claim(hid_t file, const char* path, hsize_t length, hsize_t chunk,
           hid_t type = H5T_IEEE_F64LE) {
  const bool contiguous = chunk == 0;
  H5Ldelete(file, path, H5P_DEFAULT);
  const hsize_t unlimited = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(1, &length, contiguous ? nullptr : &unlimited);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  if (contiguous)
    H5Pset_alloc_time(properties, H5D_ALLOC_TIME_LATE);
  else
    H5Pset_chunk(properties, 1, &chunk);
  const hid_t data = H5Dcreate2(file, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  EXPECT_GE(data, 0);
  H5Dclose(data);
  H5Pclose(properties);
  H5Sclose(space);
}

TEST(HostileCaptures, TenGigabytesClaimedInAKilobyte) {
  const TempFolder folder;
  const std::string path = folder.path("c.h5");
  {
    h5::H5Writer writer(path);
    writer.attribute("/", "schema", std::string("tenter.capture"));
    writer.attribute("/", "version", std::int64_t{1});
    ASSERT_TRUE(std::move(writer).save());
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    for (const char* name : {"/entry", "/entry/data"})
      H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    claim(file, "/entry/title", 1, 1);
    claim(file, "/entry/data/frame", 2500000000, 1024, H5T_STD_I32LE);
    H5Fclose(file);
  }
  EXPECT_LT(std::filesystem::file_size(path), 4096U);
  const auto capture = read_capture_guarded(path);
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().message, path + ": /entry/title: must hold text of fixed length.");
  const auto frames = h5::H5Reader::open(path)->ints("/entry/data/frame");
  ASSERT_FALSE(frames);
  EXPECT_EQ(
      frames.error().message,
      path + ": /entry/data/frame: claims 2500000000 values, more than the limit of 2147 MB.");
}

TEST(HostileCaptures, SizesThatTheFileCannotHold) {
  EXPECT_EQ(
      said_of(small_capture(), [](hid_t f) { claim(f, "/entry/data/time", 1250000000, 1024); }),
      "/entry/data/time@units: is missing.");
  EXPECT_EQ(
      said_of(small_capture(), [](hid_t f) { claim(f, "/entry/data/run", 1250000000, 1024); }),
      "/entry/data/run: must hold whole numbers.");
  EXPECT_EQ(
      said_of(small_capture(),
              [](hid_t f) { claim(f, "/entry/protocol/phase_nominal_rate", 1250000000, 1024); }),
      "/entry/protocol/phase_nominal_rate: claims 1250000000 values, more than the limit of "
      "2147 MB.");
  const std::string message = said_of(small_capture(), [](hid_t f) {
    claim(f, "/entry/protocol/phase_nominal_rate", 100000000, 1024);
  });
  EXPECT_TRUE(
      message.starts_with("/entry/protocol/phase_nominal_rate: claims 800 MB but the file of "))
      << message;
  EXPECT_NE(message.find("stores 0 bytes of it."), std::string::npos) << message;
  EXPECT_NE(said_of(small_capture(),
                    [](hid_t f) { claim(f, "/entry/protocol/phase_nominal_rate", 100000000, 0); })
                .find("claims 800 MB"),
            std::string::npos);
}

TEST(HostileCaptures, HugeChunks) {
  // two values, but reading them would make HDF5 reserve a chunk of two gigabytes
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) { claim(f, "/entry/protocol/phase_nominal_rate", 2, 1 << 28); }),
            "/entry/protocol/phase_nominal_rate: claims chunks larger than 67 MB.");
}

TEST(HostileCaptures, WrongTypesShapesAndMissingGroups) {
  EXPECT_EQ(said_of(small_capture(), [](hid_t f) { H5Ldelete(f, "/entry/sample", H5P_DEFAULT); }),
            "/entry/sample/name: is missing.");
  EXPECT_EQ(said_of(small_capture(), [](hid_t f) { H5Ldelete(f, "/entry", H5P_DEFAULT); }),
            "/entry/title: is missing.");
  EXPECT_EQ(
      said_of(small_capture(), [](hid_t f) { H5Adelete_by_name(f, "/", "version", H5P_DEFAULT); }),
      "/@version: is missing.");
  EXPECT_EQ(
      said_of(small_capture(),
              [](hid_t f) { H5Adelete_by_name(f, "/entry/data/force", "units", H5P_DEFAULT); }),
      "/entry/data/force@units: is missing.");
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) {
                      H5Ldelete(f, "/entry/title", H5P_DEFAULT);
                      H5Lmove(f, "/entry/runs/number", f, "/entry/title", H5P_DEFAULT, H5P_DEFAULT);
                    }),
            "/entry/title: must hold text of fixed length.");
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) {
                      H5Ldelete(f, "/entry/data/branch", H5P_DEFAULT);
                      H5Lcreate_hard(f, "/entry/data/frame", f, "/entry/data/branch", H5P_DEFAULT,
                                     H5P_DEFAULT);
                    }),
            "/entry/data/branch: holds 5, not 0 to 3.");
}

TEST(HostileCaptures, LinksThatLeadElsewhereAreNotFollowed) {
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) {
                      H5Ldelete(f, "/entry/title", H5P_DEFAULT);
                      H5Lcreate_external("/etc/passwd", "/x", f, "/entry/title", H5P_DEFAULT,
                                         H5P_DEFAULT);
                    }),
            "/entry/title: is missing.");
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) {
                      H5Ldelete(f, "/entry/title", H5P_DEFAULT);
                      H5Lcreate_soft("/entry/title", f, "/entry/title", H5P_DEFAULT, H5P_DEFAULT);
                    }),
            "/entry/title: is missing.");
  EXPECT_EQ(said_of(small_capture(),
                    [](hid_t f) {
                      // a group that contains itself
                      H5Lcreate_hard(f, "/entry", f, "/entry/sample/again", H5P_DEFAULT,
                                     H5P_DEFAULT);
                    }),
            "accepted");
}

/// A dataset of `length` numbers that is a view of "/part" in `source`.
void view(hid_t file, const char* path, const char* source, hsize_t length) {
  const hid_t space = H5Screate_simple(1, &length, nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  EXPECT_GE(H5Pset_virtual(properties, space, source, "/part", space), 0);
  const hid_t data =
      H5Dcreate2(file, path, H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  EXPECT_GE(data, 0);
  H5Dclose(data);
  H5Pclose(properties);
  H5Sclose(space);
}

TEST(HostileCaptures, ViewsShowOwnNumbersOfBelievableSizeOnly) {
  const TempFolder folder;
  const std::string path = folder.path("v.h5");
  {
    h5::H5Writer writer(path);
    writer.array("/part", std::vector<double>{1, 2, 3}, "m");
    ASSERT_TRUE(std::move(writer).save());
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    view(file, "/own", ".", 3);
    view(file, "/other", "/etc/passwd", 3);
    view(file, "/hidden", "./v.h5", 3);
    view(file, "/huge", ".", 200000000);
    H5Fclose(file);
  }
  const auto reader = h5::H5Reader::open(path);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->table("/own")->values, (std::vector<double>{1, 2, 3}));
  for (const char* name : {"/other", "/hidden"}) {
    const auto table = reader->table(name);
    ASSERT_FALSE(table) << name;
    EXPECT_EQ(table.error().message, path + ": " + name + ": is stored outside the file.");
  }
  const auto huge = reader->table("/huge");
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("claims 1600 MB but the file has"), std::string::npos);
  const auto list = reader->doubles("/own");  // what captures are read with knows no views
  ASSERT_FALSE(list);
  EXPECT_NE(list.error().message.find("is stored in a way that"), std::string::npos);
}

TEST(HostileCaptures, UnknownGroupsAreIgnoredAndListed) {
  const TempFolder folder;
  const std::string path = folder.path("c.h5");
  ASSERT_TRUE(write_capture(small_capture(), path));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  for (const char* name : {"/entry/meshes", "/entry/data/extra", "/other"})
    H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Fclose(file);
  std::vector<std::string> ignored;
  const auto capture = read_capture_guarded(path, &ignored);
  ASSERT_TRUE(capture) << message_of(capture);
  EXPECT_EQ(ignored, (std::vector<std::string>{"/entry/data/extra", "/other", "/entry/meshes"}));
}

TEST(HostileCaptures, EveryTruncationIsRefused) {
  const TempFolder folder;
  const std::string good = bytes_of(small_capture());
  for (std::size_t size = 0; size < good.size(); size += 1 + good.size() / 60) {
    put_file(folder.path("c.h5"), good.substr(0, size));
    const auto capture = read_capture_guarded(folder.path("c.h5"));
    ASSERT_FALSE(capture) << size;
    EXPECT_EQ(capture.error().kind, ErrorKind::bad_input);
  }
}

TEST(HostileCaptures, MutatedFilesAreRefusedOrEqual) {
  const TempFolder folder;
  const std::string path = folder.path("c.h5");
  const std::string good = bytes_of(small_capture());
  std::mt19937 generator(7);
  int refused = 0;
  int equal = 0;
  for (int i = 0; i < 500; ++i) {
    put_file(path, mutated(good, generator));
    const auto capture = read_capture_guarded(path);
    if (!capture) {
      ++refused;
      EXPECT_EQ(capture.error().kind, ErrorKind::bad_input) << capture.error().message;
      EXPECT_TRUE(capture.error().message.starts_with(path)) << capture.error().message;
      continue;
    }
    ++equal;
    EXPECT_TRUE(bytes_of(*capture) == good) << "mutation " << i << " changed the content unseen";
  }
  std::printf("500 mutated files: %d refused, %d equal\n", refused, equal);
  EXPECT_GT(refused, 250);
  EXPECT_GT(equal, 0);
}

/// Without checksums of metadata (the older format, which other programs write) flips reach HDF5's
/// parser.
TEST(HostileCaptures, MutatedFilesOfTheOlderFormatNeverCrashTheReader) {
  const TempFolder folder;
  const std::string path = folder.path("old.h5");
  const std::string good_path = folder.path("good.h5");
  ASSERT_TRUE(write_capture(small_capture(), good_path));
  {
    // the same objects copied into a file of the earliest format
    const hid_t from = H5Fopen(good_path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t to = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    ASSERT_GE(H5Ocopy(from, "/entry", to, "/entry", H5P_DEFAULT, H5P_DEFAULT), 0);
    for (const char* name : {"schema", "version"}) {
      const hid_t attribute = H5Aopen_by_name(from, "/", name, H5P_DEFAULT, H5P_DEFAULT);
      const hid_t type = H5Aget_type(attribute);
      const hid_t space = H5Aget_space(attribute);
      std::vector<char> value(H5Tget_size(type));
      H5Aread(attribute, type, value.data());
      const hid_t copy =
          H5Acreate_by_name(to, "/", name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(copy, type, value.data());
      H5Aclose(copy);
      H5Sclose(space);
      H5Tclose(type);
      H5Aclose(attribute);
    }
    H5Fclose(to);
    H5Fclose(from);
  }
  const std::string good = get_file(path);
  const auto whole = read_capture_guarded(path);
  ASSERT_TRUE(whole) << message_of(whole);
  EXPECT_EQ(bytes_of(*whole), bytes_of(small_capture()));
  std::mt19937 generator(13);
  int refused = 0;
  int crashed = 0;
  for (int i = 0; i < 400; ++i) {
    put_file(path, mutated(good, generator));
    const auto capture = read_capture_guarded(path);
    if (capture) continue;
    ++refused;
    crashed += capture.error().message.find("the HDF5 library") != std::string::npos;
    EXPECT_EQ(capture.error().kind, ErrorKind::bad_input) << capture.error().message;
  }
  std::printf("400 mutated files of the older format: %d refused, of these %d by the guard\n",
              refused, crashed);
  EXPECT_GT(refused, 50);
}

TEST(HostileCaptures, MutatedResidualsAreRefusedOrRead) {
  report::ResidualTable table;
  table.capture_id = std::string(64, 'a');
  table.channel = "force";
  table.unit = "N/m";
  for (int i = 0; i < 50; ++i) {
    table.frame.push_back(i);
    table.run.push_back(1);
    table.block.push_back(0);
    table.branch.push_back(0);
    for (auto* column :
         {&table.time_s, &table.strain_x, &table.strain_y, &table.strain_xy, &table.measured,
          &table.predicted_baseline, &table.predicted_extended, &table.sigma, &table.weight})
      column->push_back(0.1 * i);
  }
  const TempFolder folder;
  const std::string path = folder.path("r.h5");
  ASSERT_TRUE(report::write_residuals({table}, path));
  const std::string good = get_file(path);
  std::mt19937 generator(17);
  int refused = 0;
  for (int i = 0; i < 150; ++i) {
    put_file(path, mutated(good, generator));
    const auto tables = report::read_residuals_guarded(path);
    if (!tables) {
      ++refused;
      continue;
    }
    ASSERT_EQ(tables->size(), 1U);
    EXPECT_EQ(tables->front().measured, table.measured);
  }
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace tenter::capture
