// SPDX-License-Identifier: Apache-2.0
// Writes one HDF5 file whose bytes depend on its content only, so that the content names the file.
//
//   H5Writer file(path);
//   file.group("/entry", "NXentry");
//   file.text("/entry/title", "a title");
//   file.array("/entry/data/force", values, "N");
//   Expected<void> done = std::move(file).save();
//
// The file is built in memory (a memfd), then written beside `path`, synced and renamed
// into place: a reader sees the old file or the whole new one. Arrays are chunked, deflated and
// carry Fletcher32 checksums; scalars and texts live in object headers, which the 1.10 format
// checksums too. No time stamps are stored. The first failure is kept and reported by save(). One
// writer per thread; calls into HDF5 are serialised.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::h5 {

class H5Writer {
 public:
  explicit H5Writer(const std::string& path);
  H5Writer(H5Writer&&) noexcept;
  H5Writer& operator=(H5Writer&&) noexcept;
  ~H5Writer();

  /// Creates a group; "/" is there already and only gets the class.
  void group(const std::string& path, const std::string& nx_class);

  // scalar datasets
  void text(const std::string& path, const std::string& value);
  void number(const std::string& path, double value, const std::string& unit);
  void integer(const std::string& path, std::int64_t value);

  // one-dimensional datasets; `unit` "" leaves the attribute out
  void array(const std::string& path, const std::vector<double>& values, const std::string& unit);
  void array(const std::string& path, const std::vector<int>& values);
  void array(const std::string& path, const std::vector<std::string>& values);

  /// Of several dimensions, the last one running fastest; `shape` multiplies to the number of
  /// values. One chunk never spans two entries of the first dimension where these are large.
  void array(const std::string& path, const std::vector<double>& values,
             const std::vector<std::size_t>& shape, const std::string& unit);
  void array(const std::string& path, const std::vector<int>& values,
             const std::vector<std::size_t>& shape);

  /// Datasets of one shape seen as one of a dimension more (a virtual dataset): entry i is
  /// `parts[i]`. Nothing is stored twice.
  void stack(const std::string& path, const std::vector<std::string>& parts,
             const std::vector<std::size_t>& part_shape, const std::string& unit);

  // attributes of an existing object
  void attribute(const std::string& path, const std::string& name, const std::string& value);
  void attribute(const std::string& path, const std::string& name,
                 const std::vector<std::string>& values);
  void attribute(const std::string& path, const std::string& name, double value);
  void attribute(const std::string& path, const std::string& name, std::int64_t value);

  /// Ends the file and puts it at its path. A full disk is ErrorKind::no_space.
  Expected<void> save() &&;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::h5
