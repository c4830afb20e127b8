// SPDX-License-Identifier: Apache-2.0
#include "common/h5/reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>

#include "common/h5/dataset_checks.h"
#include "common/h5/handle.h"

namespace tenter::h5 {

struct H5Reader::Impl : DatasetChecks {
  Handle file;

  /// Is the object there? Every link on the way must be a hard link: no file may lead the reader
  /// into another.
  Expected<bool> there(const std::string& path) const {
    if (path == "/") return true;
    for (std::size_t at = path.find('/', 1);; at = path.find('/', at + 1)) {
      const std::string part = path.substr(0, at);
      const htri_t exists = H5Lexists(file.get(), part.c_str(), H5P_DEFAULT);
      if (exists < 0) return complaint(part, "cannot be looked up; the file is damaged");
      if (exists == 0) return false;
      H5L_info_t link{};
      if (H5Lget_info(file.get(), part.c_str(), &link, H5P_DEFAULT) < 0)
        return complaint(part, "cannot be looked up; the file is damaged");
      if (link.type != H5L_TYPE_HARD) return false;
      if (at == std::string::npos) return true;
    }
  }
  Expected<void> require(const std::string& path) const {
    const Expected<bool> is_there = there(path);
    if (!is_there) return tl::unexpected(is_there.error());
    if (!*is_there) return complaint(path, "is missing");
    return {};
  }
  Expected<bool> has_attribute(const std::string& path, const std::string& name) const {
    if (auto ok = require(path); !ok) return tl::unexpected(ok.error());
    const htri_t exists = H5Aexists_by_name(file.get(), path.c_str(), name.c_str(), H5P_DEFAULT);
    if (exists < 0) return complaint(path + "@" + name, "cannot be looked up; the file is damaged");
    return exists > 0;
  }

  /// Opens, checks and reads a dataset into `bytes`, which holds `count` elements of `memory_type`
  /// or of text.
  struct Raw {
    std::vector<char> bytes;
    std::uint64_t count = 0;
    std::size_t size = 0;
    std::vector<std::uint64_t> shape = {};
  };
  Expected<Handle> open_dataset(const std::string& path) const {
    if (auto ok = require(path); !ok) return tl::unexpected(ok.error());
    Handle dataset(H5Oopen(file.get(), path.c_str(), H5P_DEFAULT));
    if (!dataset) return complaint(path, "cannot be opened; the file is damaged");
    if (H5Iget_type(dataset.get()) != H5I_DATASET) return complaint(path, "must be a dataset");
    return dataset;
  }
  Expected<Raw> read(const std::string& path, Wanted wanted, Extent extent) const {
    const std::lock_guard lock(library_lock());
    const Expected<Handle> opened = open_dataset(path);
    if (!opened) return tl::unexpected(opened.error());
    const Handle& dataset = *opened;
    const Handle type(H5Dget_type(dataset.get()));
    const Handle space(H5Dget_space(dataset.get()));
    if (!type || !space) return complaint(path, "cannot be read; the file is damaged");
    const auto size = element_size(type.get(), wanted, path);
    if (!size) return tl::unexpected(size.error());
    auto shape = shape_of(space.get(), extent, path);
    if (!shape) return tl::unexpected(shape.error());
    const auto count = element_count(*shape, path);
    if (!count) return tl::unexpected(count.error());
    const std::uint64_t in_memory = wanted == Wanted::text ? *size : 8;
    if (auto ok = affordable(*count, in_memory, path); !ok) return tl::unexpected(ok.error());
    if (auto ok = believable(dataset.get(), *count, *size, extent, path); !ok)
      return tl::unexpected(ok.error());
    Raw raw{std::vector<char>(*count * in_memory), *count, static_cast<std::size_t>(in_memory),
            std::move(*shape)};
    if (*count > 0 && H5Dread(dataset.get(), memory_type(type.get(), wanted), H5S_ALL, H5S_ALL,
                              H5P_DEFAULT, raw.bytes.data()) < 0)
      return complaint(path, "cannot be read: a checksum fails or the file is damaged");
    return raw;
  }

  Expected<Raw> read_attribute(const std::string& path, const std::string& name,
                               Wanted wanted) const {
    const std::lock_guard lock(library_lock());
    const std::string object = path + "@" + name;
    const Expected<bool> is_there = has_attribute(path, name);
    if (!is_there) return tl::unexpected(is_there.error());
    if (!*is_there) return complaint(object, "is missing");
    const Handle attribute(
        H5Aopen_by_name(file.get(), path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
    if (!attribute) return complaint(object, "cannot be opened; the file is damaged");
    const Handle type(H5Aget_type(attribute.get()));
    const Handle space(H5Aget_space(attribute.get()));
    if (!type || !space) return complaint(object, "cannot be read; the file is damaged");
    const auto size = element_size(type.get(), wanted, object);
    if (!size) return tl::unexpected(size.error());
    if (auto shape = shape_of(space.get(), Extent::scalar, object); !shape)
      return tl::unexpected(shape.error());
    const std::size_t in_memory = wanted == Wanted::text ? *size : 8;
    Raw raw{std::vector<char>(in_memory), 1, in_memory};
    if (H5Aread(attribute.get(), memory_type(type.get(), wanted), raw.bytes.data()) < 0)
      return complaint(object, "cannot be read; the file is damaged");
    return raw;
  }

  static hid_t memory_type(hid_t file_type, Wanted wanted) {
    switch (wanted) {
      case Wanted::real:
        return H5T_NATIVE_DOUBLE;
      case Wanted::integer:
        return H5T_NATIVE_INT64;
      case Wanted::text:
        return file_type;
    }
    return file_type;
  }

  template <class T>
  static std::vector<T> as(const Raw& raw) {
    std::vector<T> values(raw.count);
    if (raw.count > 0) std::memcpy(values.data(), raw.bytes.data(), raw.count * sizeof(T));
    return values;
  }

  static std::string text_at(const Raw& raw, std::size_t i) {
    const char* begin = raw.bytes.data() + i * raw.size;
    return std::string(begin, std::find(begin, begin + raw.size, '\0'));
  }
};

H5Reader::H5Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
H5Reader::H5Reader(H5Reader&&) noexcept = default;
H5Reader& H5Reader::operator=(H5Reader&& other) noexcept {
  const std::lock_guard lock(library_lock());
  impl_ = std::move(other.impl_);
  return *this;
}
H5Reader::~H5Reader() {
  const std::lock_guard lock(library_lock());
  impl_.reset();
}

Expected<H5Reader> H5Reader::open(const std::string& path, const Limits& limits) {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0)
    return fail(errno == ENOENT ? ErrorKind::not_found : ErrorKind::bad_input,
                path + ": " + std::strerror(errno) + ".");
  if (!S_ISREG(status.st_mode)) return bad_input(path + ": is not a regular file.");
  const std::lock_guard lock(library_lock());
  auto impl = std::make_unique<Impl>();
  impl->file_name = path;
  impl->limits = limits;
  impl->file_bytes = static_cast<std::uint64_t>(status.st_size);
  if (H5Fis_hdf5(path.c_str()) <= 0)
    return bad_input(path + ": is not an HDF5 file (or is truncated at its start).");
  Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  impl->file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()));
  if (!impl->file) return bad_input(path + ": HDF5 cannot open it; it is truncated or damaged.");
  return H5Reader(std::move(impl));
}

Expected<bool> H5Reader::has(const std::string& path) const {
  const std::lock_guard lock(library_lock());
  return impl_->there(path);
}

Expected<std::vector<std::string>> H5Reader::members(const std::string& group) const {
  const std::lock_guard lock(library_lock());
  if (auto ok = impl_->require(group); !ok) return tl::unexpected(ok.error());
  const Handle handle(H5Oopen(impl_->file.get(), group.c_str(), H5P_DEFAULT));
  if (handle && H5Iget_type(handle.get()) != H5I_GROUP) return complaint(group, "must be a group");
  H5G_info_t info{};
  if (!handle || H5Gget_info(handle.get(), &info) < 0)
    return complaint(group, "cannot be read; the file is damaged");
  if (info.nlinks > impl_->limits.members) return complaint(group, "has too many members");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 1024> name{};
    const ssize_t length = H5Lget_name_by_idx(handle.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i,
                                              name.data(), name.size(), H5P_DEFAULT);
    if (length <= 0) return complaint(group, "has a member without a readable name");
    names.emplace_back(name.data());
  }
  return names;
}

Expected<std::string> H5Reader::text(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::text, Extent::scalar);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::text_at(*raw, 0);
}

Expected<double> H5Reader::number(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::real, Extent::scalar);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::as<double>(*raw)[0];
}

Expected<std::int64_t> H5Reader::integer(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::integer, Extent::scalar);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::as<std::int64_t>(*raw)[0];
}

Expected<std::vector<double>> H5Reader::doubles(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::real, Extent::list);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::as<double>(*raw);
}

Expected<std::vector<int>> H5Reader::ints(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::integer, Extent::list);
  if (!raw) return tl::unexpected(raw.error());
  std::vector<int> values;
  values.reserve(raw->count);
  for (const std::int64_t value : Impl::as<std::int64_t>(*raw)) {
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max())
      return complaint(path, "holds the number " + std::to_string(value) + ", out of range");
    values.push_back(static_cast<int>(value));
  }
  return values;
}

Expected<std::vector<std::string>> H5Reader::texts(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::text, Extent::list);
  if (!raw) return tl::unexpected(raw.error());
  std::vector<std::string> values;
  values.reserve(raw->count);
  for (std::size_t i = 0; i < raw->count; ++i) values.push_back(Impl::text_at(*raw, i));
  return values;
}

Expected<H5Reader::Table> H5Reader::table(const std::string& path) const {
  auto raw = impl_->read(path, Wanted::real, Extent::table);
  if (!raw) return tl::unexpected(raw.error());
  return Table{raw->shape, Impl::as<double>(*raw)};
}

Expected<std::vector<std::uint64_t>> H5Reader::shape(const std::string& path) const {
  const std::lock_guard lock(library_lock());
  const Expected<Handle> dataset = impl_->open_dataset(path);
  if (!dataset) return tl::unexpected(dataset.error());
  const Handle space(H5Dget_space(dataset->get()));
  if (!space) return complaint(path, "cannot be read; the file is damaged");
  return impl_->shape_of(space.get(), Extent::table, path);
}

Expected<bool> H5Reader::has_attribute(const std::string& path, const std::string& name) const {
  const std::lock_guard lock(library_lock());
  return impl_->has_attribute(path, name);
}

Expected<std::string> H5Reader::text_attribute(const std::string& path,
                                               const std::string& name) const {
  auto raw = impl_->read_attribute(path, name, Wanted::text);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::text_at(*raw, 0);
}

Expected<double> H5Reader::number_attribute(const std::string& path,
                                            const std::string& name) const {
  auto raw = impl_->read_attribute(path, name, Wanted::real);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::as<double>(*raw)[0];
}

Expected<std::int64_t> H5Reader::integer_attribute(const std::string& path,
                                                   const std::string& name) const {
  auto raw = impl_->read_attribute(path, name, Wanted::integer);
  if (!raw) return tl::unexpected(raw.error());
  return Impl::as<std::int64_t>(*raw)[0];
}

tl::unexpected<Error> H5Reader::complaint(const std::string& object,
                                          const std::string& what) const {
  return impl_->complaint(object, what);
}

}  // namespace tenter::h5
