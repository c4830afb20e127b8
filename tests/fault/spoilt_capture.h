// SPDX-License-Identifier: GPL-3.0-or-later
// Captures spoilt on purpose, and what the guarded reader says of them.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <string>

#include "common/capture/file/capture_file.h"
#include "tests/common/capture/support.h"

namespace tenter::fault {

/// Opens a good capture with plain HDF5, lets `change` spoil it, and returns what the reader says
/// behind the file's name; "accepted" where it takes it.
inline std::string said_of(const capture::Capture& good,
                           const std::function<void(hid_t file)>& change) {
  const capture::test::TempFolder folder;
  const std::string path = folder.path("c.h5");
  EXPECT_TRUE(capture::write_capture(good, path));
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  EXPECT_GE(file, 0);
  change(file);
  EXPECT_GE(H5Fclose(file), 0);
  const auto capture = capture::read_capture_guarded(path);
  if (capture) return "accepted";
  EXPECT_EQ(capture.error().kind, ErrorKind::bad_input);
  const std::string& message = capture.error().message;
  EXPECT_TRUE(message.starts_with(path + ": ")) << message;
  return message.substr(path.size() + 2);
}

}  // namespace tenter::fault
