// SPDX-License-Identifier: Apache-2.0
#include "common/h5/writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <numeric>

#include "common/base/atomic_write.h"
#include "common/h5/handle.h"

namespace tenter::h5 {

namespace {

constexpr hsize_t kChunkElements = 16384;
constexpr hsize_t kTableChunkElements = 65536;
constexpr unsigned kDeflateLevel = 4;
constexpr std::size_t kMemoryStep = std::size_t{1} << 20;

/// Fixed-length UTF-8 text of `length` bytes, padded with zeros. Length 0 does not exist in HDF5.
Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), std::max<std::size_t>(length, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// Texts side by side in cells of the longest one's length.
std::vector<char> packed(const std::vector<std::string>& values, std::size_t* length) {
  *length = 1;
  for (const std::string& value : values) *length = std::max(*length, value.size());
  std::vector<char> bytes(*length * values.size(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i)
    std::memcpy(bytes.data() + i * *length, values[i].data(), values[i].size());
  return bytes;
}

hsize_t count_of(const std::vector<hsize_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>());
}

/// From the last dimension on, as much as fits.
std::vector<hsize_t> chunk_of(const std::vector<hsize_t>& shape) {
  std::vector<hsize_t> chunk(shape.size(), 1);
  hsize_t room = shape.size() == 1 ? kChunkElements : kTableChunkElements;
  for (std::size_t i = shape.size(); i-- > 0;) {
    chunk[i] = std::min(shape[i], room);
    room = chunk[i] == shape[i] ? std::max<hsize_t>(1, room / shape[i]) : 1;
  }
  return chunk;
}

}  // namespace

struct H5Writer::Impl {
  explicit Impl(Expected<AtomicFile> target) : place(std::move(target)) {}

  Expected<AtomicFile> place;
  Handle file;
  std::string failed;  ///< the first object that HDF5 refused
  int failed_code = 0;

  void note(bool ok, const std::string& what) {
    if (ok || !failed.empty()) return;
    failed = what;
    failed_code = errno != 0 ? errno : EINVAL;
  }

  /// Properties of a dataset: no times; chunks with checksums for arrays, inside the header for
  /// scalars (no dimensions) and what is empty.
  static Handle dataset_properties(const std::vector<hsize_t>& shape) {
    Handle properties(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_obj_track_times(properties.get(), false);
    if (count_of(shape) == 0 || shape.empty()) {
      H5Pset_layout(properties.get(), H5D_COMPACT);
      return properties;
    }
    const std::vector<hsize_t> chunk = chunk_of(shape);
    H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
    H5Pset_shuffle(properties.get());
    H5Pset_deflate(properties.get(), kDeflateLevel);
    H5Pset_fletcher32(properties.get());
    return properties;
  }

  void dataset(const std::string& path, hid_t file_type, hid_t memory_type,
               const std::vector<hsize_t>& shape, const void* data) {
    const Handle space(
        shape.empty() ? H5Screate(H5S_SCALAR)
                      : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
    const Handle properties = dataset_properties(shape);
    Handle dataset(H5Dcreate2(file.get(), path.c_str(), file_type, space.get(), H5P_DEFAULT,
                              properties.get(), H5P_DEFAULT));
    note(dataset && (!data || H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                       data) >= 0),
         path);
  }

  /// A shape that does not hold the values is a defect of the caller: an empty list, and noted.
  std::vector<hsize_t> extent(const std::string& path, const std::vector<std::size_t>& shape,
                              std::size_t values) {
    std::vector<hsize_t> result(shape.begin(), shape.end());
    if (!result.empty() && count_of(result) == values) return result;
    note(false, path);
    return {0};
  }

  void put_attribute(const std::string& path, const std::string& name, hid_t file_type,
                     hid_t memory_type, const Handle& space, const void* data) {
    Handle attribute(H5Acreate_by_name(file.get(), path.c_str(), name.c_str(), file_type,
                                       space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    note(attribute && H5Awrite(attribute.get(), memory_type, data) >= 0, path + "@" + name);
  }
};

H5Writer::H5Writer(const std::string& path)
    : impl_(std::make_unique<Impl>(AtomicFile::create(path))) {
  if (!impl_->place) return;
  const std::lock_guard lock(library_lock());
  errno = 0;
  Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fapl_core(access.get(), kMemoryStep, true);
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110);
  Handle creation(H5Pcreate(H5P_FILE_CREATE));
  H5Pset_obj_track_times(creation.get(), false);
  impl_->file = Handle(
      H5Fcreate(impl_->place->temporary().c_str(), H5F_ACC_TRUNC, creation.get(), access.get()));
  impl_->note(static_cast<bool>(impl_->file), "/");
}
H5Writer::H5Writer(H5Writer&&) noexcept = default;
H5Writer& H5Writer::operator=(H5Writer&& other) noexcept {
  const std::lock_guard lock(library_lock());
  impl_ = std::move(other.impl_);
  return *this;
}
H5Writer::~H5Writer() {
  const std::lock_guard lock(library_lock());
  impl_.reset();
}

void H5Writer::group(const std::string& path, const std::string& nx_class) {
  const std::lock_guard lock(library_lock());
  if (path != "/") {
    Handle creation(H5Pcreate(H5P_GROUP_CREATE));
    H5Pset_obj_track_times(creation.get(), false);
    Handle group(
        H5Gcreate2(impl_->file.get(), path.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT));
    impl_->note(static_cast<bool>(group), path);
  }
  attribute(path, "NX_class", nx_class);
}

void H5Writer::text(const std::string& path, const std::string& value) {
  const std::lock_guard lock(library_lock());
  const Handle type = text_type(value.size());
  impl_->dataset(path, type.get(), type.get(), {}, value.empty() ? "\0" : value.data());
}

void H5Writer::number(const std::string& path, double value, const std::string& unit) {
  const std::lock_guard lock(library_lock());
  impl_->dataset(path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {}, &value);
  if (!unit.empty()) attribute(path, "units", unit);
}

void H5Writer::integer(const std::string& path, std::int64_t value) {
  const std::lock_guard lock(library_lock());
  impl_->dataset(path, H5T_STD_I64LE, H5T_NATIVE_INT64, {}, &value);
}

void H5Writer::array(const std::string& path, const std::vector<double>& values,
                     const std::string& unit) {
  array(path, values, {values.size()}, unit);
}

void H5Writer::array(const std::string& path, const std::vector<int>& values) {
  array(path, values, {values.size()});
}

void H5Writer::array(const std::string& path, const std::vector<double>& values,
                     const std::vector<std::size_t>& shape, const std::string& unit) {
  const std::lock_guard lock(library_lock());
  impl_->dataset(path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, impl_->extent(path, shape, values.size()),
                 values.empty() ? nullptr : values.data());
  if (!unit.empty()) attribute(path, "units", unit);
}

void H5Writer::array(const std::string& path, const std::vector<int>& values,
                     const std::vector<std::size_t>& shape) {
  const std::lock_guard lock(library_lock());
  impl_->dataset(path, H5T_STD_I32LE, H5T_NATIVE_INT, impl_->extent(path, shape, values.size()),
                 values.empty() ? nullptr : values.data());
}

void H5Writer::stack(const std::string& path, const std::vector<std::string>& parts,
                     const std::vector<std::size_t>& part_shape, const std::string& unit) {
  const std::lock_guard lock(library_lock());
  std::vector<hsize_t> shape(part_shape.begin(), part_shape.end());
  const Handle part(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
  std::vector<hsize_t> start(shape.size() + 1, 0), count(shape);
  shape.insert(shape.begin(), parts.size());
  count.insert(count.begin(), 1);
  const Handle whole(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  for (const std::string& name : parts) {
    H5Sselect_hyperslab(whole.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
    impl_->note(H5Pset_virtual(properties.get(), whole.get(), ".", name.c_str(), part.get()) >= 0,
                path);
    ++start[0];
  }
  H5Sselect_all(whole.get());
  const Handle dataset(H5Dcreate2(impl_->file.get(), path.c_str(), H5T_IEEE_F64LE, whole.get(),
                                  H5P_DEFAULT, properties.get(), H5P_DEFAULT));
  impl_->note(static_cast<bool>(dataset), path);
  if (!unit.empty()) attribute(path, "units", unit);
}

void H5Writer::array(const std::string& path, const std::vector<std::string>& values) {
  const std::lock_guard lock(library_lock());
  std::size_t length = 1;
  const std::vector<char> bytes = packed(values, &length);
  const Handle type = text_type(length);
  impl_->dataset(path, type.get(), type.get(), {values.size()},
                 values.empty() ? nullptr : bytes.data());
}

void H5Writer::attribute(const std::string& path, const std::string& name,
                         const std::string& value) {
  const std::lock_guard lock(library_lock());
  const Handle type = text_type(value.size());
  const Handle space(H5Screate(H5S_SCALAR));
  impl_->put_attribute(path, name, type.get(), type.get(), space,
                       value.empty() ? "\0" : value.data());
}

void H5Writer::attribute(const std::string& path, const std::string& name,
                         const std::vector<std::string>& values) {
  const std::lock_guard lock(library_lock());
  std::size_t length = 1;
  const std::vector<char> bytes = packed(values, &length);
  const Handle type = text_type(length);
  const hsize_t count = values.size();
  const Handle space(H5Screate_simple(1, &count, nullptr));
  impl_->put_attribute(path, name, type.get(), type.get(), space, bytes.data());
}

void H5Writer::attribute(const std::string& path, const std::string& name, double value) {
  const std::lock_guard lock(library_lock());
  const Handle space(H5Screate(H5S_SCALAR));
  impl_->put_attribute(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, space, &value);
}

void H5Writer::attribute(const std::string& path, const std::string& name, std::int64_t value) {
  const std::lock_guard lock(library_lock());
  const Handle space(H5Screate(H5S_SCALAR));
  impl_->put_attribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, space, &value);
}

Expected<void> H5Writer::save() && {
  if (!impl_->place) return tl::unexpected(impl_->place.error());
  {
    const std::lock_guard lock(library_lock());
    if (!impl_->failed.empty())
      return impl_->place->error(("HDF5: making " + impl_->failed).c_str(), impl_->failed_code);
    // the one moment at which bytes go to disk
    errno = 0;
    if (H5Fclose(impl_->file.release()) < 0)
      return impl_->place->error("writing", errno != 0 ? errno : EIO);
  }
  return impl_->place->commit();
}

}  // namespace tenter::h5
