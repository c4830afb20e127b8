// SPDX-License-Identifier: Apache-2.0
// Private: what a dataset claims against what it may and what the file stores of it, asked before a
// byte is reserved.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/h5/handle.h"
#include "common/h5/reader.h"

namespace tenter::h5 {

/// What is read must be an element type that HDF5 turns into `wanted` without guessing.
enum class Wanted { real, integer, text };
enum class Extent { scalar, list, table };

inline constexpr int kMostDimensions = 4;

/// All under the lock of the library.
struct DatasetChecks {
  std::string file_name;
  std::uint64_t file_bytes = 0;
  Limits limits;

  /// "FILE: OBJECT: WHAT." as an error of the caller's file.
  tl::unexpected<Error> complaint(const std::string& object, const std::string& what) const;
  Expected<std::size_t> element_size(hid_t type, Wanted wanted, const std::string& object) const;
  /// No dimensions for a scalar, the length of a one-dimensional dataset, all of a table.
  Expected<std::vector<std::uint64_t>> shape_of(hid_t space, Extent extent,
                                                const std::string& object) const;
  /// Number of elements; 1 for a scalar.
  Expected<std::uint64_t> element_count(const std::vector<std::uint64_t>& shape,
                                        const std::string& object) const;
  Expected<void> affordable(std::uint64_t count, std::uint64_t size,
                            const std::string& object) const;
  /// A stack of datasets: all of this file, which are checked by HDF5 as they are read.
  Expected<void> believable_stack(const Handle& properties, std::uint64_t claim,
                                  const std::string& object) const;
  /// The claim of a dataset against what the file stores of it.
  Expected<void> believable(hid_t dataset, std::uint64_t count, std::uint64_t size, Extent extent,
                            const std::string& object) const;
};

}  // namespace tenter::h5
