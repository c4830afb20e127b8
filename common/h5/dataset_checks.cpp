// SPDX-License-Identifier: Apache-2.0
#include "common/h5/dataset_checks.h"

#include <array>

namespace tenter::h5 {

namespace {

/// Deflate cannot do better than about 1032 to 1.
constexpr std::uint64_t kDeflateBest = 1040;

const char* word(Wanted wanted) {
  switch (wanted) {
    case Wanted::real:
      return "numbers";
    case Wanted::integer:
      return "whole numbers";
    case Wanted::text:
      return "text of fixed length";
  }
  return "";
}

std::string megabytes(std::uint64_t bytes) {
  if (bytes < 1000000) return std::to_string(bytes) + " bytes";
  return std::to_string(bytes / 1000000) + " MB";
}

}  // namespace

tl::unexpected<Error> DatasetChecks::complaint(const std::string& object,
                                               const std::string& what) const {
  return bad_input(file_name + ": " + object + ": " + what + ".");
}

Expected<std::size_t> DatasetChecks::element_size(hid_t type, Wanted wanted,
                                                  const std::string& object) const {
  const H5T_class_t got = H5Tget_class(type);
  const std::size_t size = H5Tget_size(type);
  bool ok = false;
  switch (wanted) {
    case Wanted::real:
      ok = (got == H5T_FLOAT || got == H5T_INTEGER) && size <= 8;
      break;
    case Wanted::integer:
      ok = got == H5T_INTEGER && size <= 8;
      break;
    case Wanted::text:
      ok = got == H5T_STRING && H5Tis_variable_str(type) == 0;
      break;
  }
  if (!ok || size == 0) return complaint(object, std::string("must hold ") + word(wanted));
  if (wanted == Wanted::text && size > limits.text_bytes)
    return complaint(object, "claims texts of " + megabytes(size) + " each");
  return size;
}

Expected<std::vector<std::uint64_t>> DatasetChecks::shape_of(hid_t space, Extent extent,
                                                             const std::string& object) const {
  const H5S_class_t kind = H5Sget_simple_extent_type(space);
  if (extent == Extent::scalar) {
    if (kind != H5S_SCALAR) return complaint(object, "must be a single value");
    return std::vector<std::uint64_t>{};
  }
  const int rank = kind == H5S_SIMPLE ? H5Sget_simple_extent_ndims(space) : 0;
  if (extent == Extent::list && rank != 1)
    return complaint(object, "must be a one-dimensional list");
  if (rank < 1 || rank > kMostDimensions)
    return complaint(object,
                     "must be a list of 1 to " + std::to_string(kMostDimensions) + " dimensions");
  std::array<hsize_t, kMostDimensions> lengths{};
  if (H5Sget_simple_extent_dims(space, lengths.data(), nullptr) != rank)
    return complaint(object, "cannot be read; the file is damaged");
  return std::vector<std::uint64_t>(lengths.begin(), lengths.begin() + rank);
}

Expected<std::uint64_t> DatasetChecks::element_count(const std::vector<std::uint64_t>& shape,
                                                     const std::string& object) const {
  std::uint64_t count = 1;
  for (const std::uint64_t length : shape) {
    if (length > 0 && count > (std::uint64_t{1} << 60) / length)
      return complaint(object, "claims more values than any memory holds");
    count *= length;
  }
  return count;
}

Expected<void> DatasetChecks::affordable(std::uint64_t count, std::uint64_t size,
                                         const std::string& object) const {
  if (count > limits.dataset_bytes / size)
    return complaint(object, "claims " + std::to_string(count) +
                                 " values, more than the limit of " +
                                 megabytes(limits.dataset_bytes));
  return {};
}

Expected<void> DatasetChecks::believable_stack(const Handle& properties, std::uint64_t claim,
                                               const std::string& object) const {
  std::size_t parts = 0;
  if (H5Pget_virtual_count(properties.get(), &parts) < 0)
    return complaint(object, "cannot be read; the file is damaged");
  for (std::size_t i = 0; i < parts; ++i) {
    std::array<char, 4> source{};
    if (H5Pget_virtual_filename(properties.get(), i, source.data(), source.size()) != 1 ||
        source[0] != '.')
      return complaint(object, "is stored outside the file");
  }
  if (claim / kDeflateBest > file_bytes)
    return complaint(object,
                     "claims " + megabytes(claim) + " but the file has " + megabytes(file_bytes));
  return {};
}

Expected<void> DatasetChecks::believable(hid_t dataset, std::uint64_t count, std::uint64_t size,
                                         Extent extent, const std::string& object) const {
  const std::uint64_t claim = count * size;
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  const Handle properties(H5Dget_create_plist(dataset));
  const H5D_layout_t layout = properties ? H5Pget_layout(properties.get()) : H5D_LAYOUT_ERROR;
  if (layout == H5D_VIRTUAL && extent == Extent::table)
    return believable_stack(properties, claim, object);
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    return complaint(object, "is stored in a way that captures do not use");
  if (layout == H5D_CONTIGUOUS && H5Pget_external_count(properties.get()) != 0)
    return complaint(object, "is stored outside the file");
  std::uint64_t best = 1;
  if (layout == H5D_CHUNKED) {
    std::array<hsize_t, kMostDimensions> chunk{};
    const int rank = H5Pget_chunk(properties.get(), kMostDimensions, chunk.data());
    std::uint64_t elements = rank >= 1 && rank <= kMostDimensions ? 1 : 0;
    const std::uint64_t most = limits.chunk_bytes / size;
    for (int i = 0; elements > 0 && i < rank; ++i) {
      const hsize_t length = chunk[static_cast<std::size_t>(i)];
      elements = length > 0 && elements <= most / length ? elements * length : 0;
    }
    if (elements == 0)
      return complaint(object, "claims chunks larger than " + megabytes(limits.chunk_bytes));
    best = kDeflateBest;
  }
  if (claim > 0 && (stored > file_bytes || claim / best > stored))
    return complaint(object, "claims " + megabytes(claim) + " but the file of " +
                                 megabytes(file_bytes) + " stores " + megabytes(stored) + " of it");
  return {};
}

}  // namespace tenter::h5
