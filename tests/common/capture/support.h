// SPDX-License-Identifier: Apache-2.0
// What the tests of captures share: a folder that goes away, a small capture of every feature, a
// quick import.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture::test {

class TempFolder {
 public:
  TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder();
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  const std::string& folder() const { return folder_; }
  std::size_t file_count() const;

 private:
  std::string folder_;
};

void put_file(const std::string& path, const std::string& bytes);
std::string get_file(const std::string& path);

/// Two runs of three frames with time, two phases, all branches, a force with sigma, a stretch with
/// a sigma per frame, a channel with a missing value, two tracked points.
Capture small_capture();

/// The bytes of the capture's file; equal bytes are equal captures.
std::string bytes_of(const Capture& capture);

/// A description of "time_s,displacement_mm,force_N" as a base that tests patch with a JSON merge
/// patch.
std::string uniaxial_description(const std::string& merge_patch = "{}");

/// Imports the two texts as pull.csv and pull.json.
Expected<Capture> import_text(const std::string& csv, const std::string& description);

/// The error's message, or "" where there is none.
template <class T>
std::string message_of(const Expected<T>& result) {
  return result ? "" : result.error().message;
}

}  // namespace tenter::capture::test
