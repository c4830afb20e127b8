// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/sha256.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

Expected<std::unique_ptr<Store>> Store::open(fs::path folder) {
  for (const char* part : {"objects", "tmp", "damaged"}) {
    if (auto made = make_folder(folder / part); !made) return tl::unexpected(made.error());
  }
  // all 256 folders now, so that storing an object never has to make one durable first
  bool made_any = false;
  for (int i = 0; i < 256; ++i) {
    static constexpr char kDigits[] = "0123456789abcdef";
    const char name[] = {kDigits[i / 16], kDigits[i % 16], 0};
    if (::mkdir((folder / "objects" / name).c_str(), 0750) == 0) {
      made_any = true;
    } else if (errno != EEXIST) {
      return tl::unexpected<Error>(
          system_error(folder / "objects" / name, "making the folder", errno));
    }
  }
  if (made_any) {
    if (auto done = sync_folder(folder / "objects"); !done) return tl::unexpected(done.error());
  }
  std::error_code error;
  for (const auto& left : fs::directory_iterator(folder / "tmp", error)) {
    std::error_code ignored;
    fs::remove_all(left.path(), ignored);
  }
  if (auto done = sync_folder(folder); !done) return tl::unexpected(done.error());
  return std::unique_ptr<Store>(new Store(std::move(folder)));
}

fs::path Store::object(const std::string& sha256) const {
  return folder_ / "objects" / sha256.substr(0, 2) / sha256.substr(2);
}

fs::path Store::temporary() {
  const std::lock_guard lock(mutex_);
  return folder_ / "tmp" / (std::to_string(::getpid()) + "-" + std::to_string(++next_temporary_));
}

Expected<void> Store::check_present(const std::string& sha256, std::uint64_t size) const {
  if (!is_sha256(sha256))
    return bad_input("'" + sha256 + "' is not a SHA-256 in 64 lower-case hex digits");
  auto stamp = stamp_of(object(sha256));
  if (!stamp) return fail(ErrorKind::not_found, "object " + sha256 + " is not in the store");
  if (size != 0 && stamp->size != size) {
    return fail(ErrorKind::internal, "object " + sha256 + " has " + std::to_string(stamp->size) +
                                         " bytes instead of " + std::to_string(size));
  }
  return {};
}

Expected<fs::path> Store::path(const std::string& sha256) {
  if (auto there = check_present(sha256, 0); !there) return tl::unexpected(there.error());
  const fs::path file = object(sha256);
  auto stamp = stamp_of(file);
  if (!stamp) return tl::unexpected(stamp.error());
  {
    const std::lock_guard lock(mutex_);
    const auto known = verified_.find(sha256);
    if (known != verified_.end() && known->second == *stamp) return file;
  }
  auto found = sha256_file(file);
  if (!found) return tl::unexpected(found.error());
  if (*found != sha256) {
    auto moved = set_aside(sha256);
    return fail(ErrorKind::internal,
                "object " + sha256 + " is damaged (its bytes now have the hash " + *found + ")" +
                    (moved ? " and was set aside" : "; " + moved.error().message));
  }
  const std::lock_guard lock(mutex_);
  verified_[sha256] = *stamp;
  return file;
}

Expected<void> Store::set_aside(const std::string& sha256) {
  const fs::path to = folder_ / "damaged" / sha256;
  if (::rename(object(sha256).c_str(), to.c_str()) != 0) {
    return tl::unexpected<Error>(system_error(to, "setting a damaged object aside", errno));
  }
  const std::lock_guard lock(mutex_);
  verified_.erase(sha256);
  return {};
}

// The bytes are synced before the rename, the folder after it: at any instant the name is
// absent or complete.
Expected<void> Store::move_in(const fs::path& file, const std::string& sha256) {
  if (path(sha256)) {  // there and sound; a damaged one was set aside by this very check
    ::unlink(file.c_str());
    return {};
  }
  if (::chmod(file.c_str(), 0440) != 0) {
    return tl::unexpected<Error>(system_error(file, "making read-only", errno));
  }
  if (auto done = sync_file(file); !done) return done;
  const fs::path to = object(sha256);
  if (auto done = rename_durably(file, to); !done) return done;
  if (auto stamp = stamp_of(to)) {
    const std::lock_guard lock(mutex_);
    verified_[sha256] = *stamp;
  }
  return {};
}

Expected<std::string> Store::put(std::string_view bytes) {
  const std::string sha256 = sha256_hex(bytes);
  const fs::path file = temporary();
  Expected<void> done = [&]() -> Expected<void> {
    auto out = open_file(file, O_WRONLY | O_CREAT | O_EXCL);
    if (!out) return tl::unexpected(out.error());
    if (auto written = write_all(out->get(), bytes, file); !written) return written;
    out->close();
    return move_in(file, sha256);
  }();
  if (!done) {
    ::unlink(file.c_str());
    return tl::unexpected(done.error());
  }
  return sha256;
}

Expected<std::string> Store::adopt(const fs::path& file, const std::string& known_sha256) {
  struct stat found {};
  if (::lstat(file.c_str(), &found) != 0)
    return tl::unexpected<Error>(system_error(file, "looking", errno));
  if (!S_ISREG(found.st_mode)) return bad_input(file.string() + ": is not a regular file");
  std::string sha256 = known_sha256;
  if (sha256.empty()) {
    auto hash = sha256_file(file);
    if (!hash) return tl::unexpected(hash.error());
    sha256 = *hash;
  }
  if (auto done = move_in(file, sha256); !done) return tl::unexpected(done.error());
  return sha256;
}

std::uint64_t Store::free_bytes() const {
  struct statvfs found {};
  if (::statvfs(folder_.c_str(), &found) != 0) return 0;
  return std::uint64_t{found.f_bavail} * found.f_frsize;
}

}  // namespace tenter::jobs
