// SPDX-License-Identifier: Apache-2.0
// Reads an HDF5 file that may be truncated, flipped or made to hurt.
//
// Nothing is allocated on the file's word: a dataset's claim is held against what the file stores
// of it and against Limits before a byte is reserved. Checksums are verified by HDF5 on the way.
// Every message starts with the file's name and names the group or dataset. HDF5's own error stack
// is never printed. A defect inside HDF5 can still crash or hang the process: files of strangers go
// through run_guarded first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::h5 {

struct Limits {
  std::uint64_t dataset_bytes = std::uint64_t{1} << 31;  ///< one dataset in memory
  std::uint64_t chunk_bytes = std::uint64_t{1} << 26;    ///< one chunk in memory
  std::uint64_t text_bytes = std::uint64_t{1} << 20;     ///< one text
  std::size_t members = 20000;                           ///< members of one group
};

class H5Reader {
 public:
  static Expected<H5Reader> open(const std::string& path, const Limits& limits = {});
  H5Reader(H5Reader&&) noexcept;
  H5Reader& operator=(H5Reader&&) noexcept;
  ~H5Reader();

  /// False only where it is not there; what cannot be told because the file is damaged is an error.
  Expected<bool> has(const std::string& path) const;
  /// Names of the members of a group, in alphabetical order.
  Expected<std::vector<std::string>> members(const std::string& group) const;

  Expected<std::string> text(const std::string& path) const;
  Expected<double> number(const std::string& path) const;
  Expected<std::int64_t> integer(const std::string& path) const;
  Expected<std::vector<double>> doubles(const std::string& path) const;
  Expected<std::vector<int>> ints(const std::string& path) const;
  Expected<std::vector<std::string>> texts(const std::string& path) const;

  /// A list of any number of dimensions (up to 4), the last one running fastest; also one stacked
  /// of others of the same file (H5Writer::stack).
  struct Table {
    std::vector<std::uint64_t> shape;
    std::vector<double> values;
  };
  Expected<Table> table(const std::string& path) const;
  /// Its shape alone.
  Expected<std::vector<std::uint64_t>> shape(const std::string& path) const;

  Expected<bool> has_attribute(const std::string& path, const std::string& name) const;
  Expected<std::string> text_attribute(const std::string& path, const std::string& name) const;
  Expected<double> number_attribute(const std::string& path, const std::string& name) const;
  Expected<std::int64_t> integer_attribute(const std::string& path, const std::string& name) const;

  /// "FILE: OBJECT: WHAT." as an error of the caller's file.
  tl::unexpected<Error> complaint(const std::string& object, const std::string& what) const;

 private:
  struct Impl;
  explicit H5Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::h5
