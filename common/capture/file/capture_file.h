// SPDX-License-Identifier: Apache-2.0
// A capture as one HDF5 file. The layout is in README.md of this folder; the bytes depend on the
// capture only, so the SHA-256 of the file names it.
//
//   Expected<void> done = write_capture(capture, "pull.h5");
//   Expected<Capture> capture = read_capture_guarded("from-somewhere.h5");
//
// Reading never trusts the file (common/h5/reader.h) and always ends in validate().
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

/// Validates, writes beside `path`, syncs, renames. Nothing is left on failure.
Expected<void> write_capture(const Capture& capture, const std::string& path);

/// Reads in this process: for files that this installation wrote and whose checksum is known.
/// `ignored`, where given, gets the objects of the file that this version does not know.
Expected<Capture> read_capture(const std::string& path,
                               std::vector<std::string>* ignored = nullptr);

/// Reads first in a child process with limits: for files of others. A crash or hang inside HDF5 is
/// an Error.
Expected<Capture> read_capture_guarded(const std::string& path,
                                       std::vector<std::string>* ignored = nullptr);

}  // namespace tenter::capture
