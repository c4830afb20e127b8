// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/uploads.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <sstream>
#include <system_error>
#include <thread>

#include "common/base/crc32c.h"
#include "common/base/sha256.h"
#include "server/jobs/store/files.h"
#include "server/jobs/store/upload_transfer.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

// Syncs behind the back of who brings the chunks; sleeps when there is nothing new.
class Uploads::Helper {
 public:
  Helper() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void look_at(const std::shared_ptr<UploadTransfer>& transfer) {
    {
      const std::lock_guard lock(mutex_);
      if (std::find(waiting_.begin(), waiting_.end(), transfer) != waiting_.end()) return;
      waiting_.push_back(transfer);
    }
    wake_.notify_one();
  }

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::shared_ptr<UploadTransfer> next;
      {
        std::unique_lock lock(mutex_);
        if (!wake_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
        next = std::move(waiting_.front());
        waiting_.erase(waiting_.begin());
      }
      // a failure here is met again, and told, by seal()
      if (next->wants_sync()) [[maybe_unused]]
        auto synced = next->sync();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<std::shared_ptr<UploadTransfer>> waiting_;
  std::jthread thread_;
};

Uploads::Uploads(fs::path folder)
    : folder_(std::move(folder)), helper_(std::make_unique<Helper>()) {}
Uploads::~Uploads() = default;

Expected<std::unique_ptr<Uploads>> Uploads::open(fs::path folder, int keep_days) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  std::unique_ptr<Uploads> uploads(new Uploads(std::move(folder)));
  const auto oldest = fs::file_time_type::clock::now() - std::chrono::hours(24 * keep_days);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(uploads->folder_, error)) {
    std::error_code ignored;
    const auto drop = [&] { fs::remove_all(entry.path(), ignored); };
    auto text = read_file(entry.path() / "request", 4096);
    UploadRequest request;
    std::istringstream words(text ? *text : "");
    const bool old = fs::last_write_time(entry.path() / "chunks", ignored) < oldest;
    if (!(words >> request.sha256 >> request.size_bytes >> request.user) ||
        !is_sha256(request.sha256) || old || entry.path().extension() == ".new") {
      drop();
      continue;
    }
    auto transfer = std::make_shared<UploadTransfer>(entry.path(), request);
    if (!transfer->resume()) {
      drop();
      continue;
    }
    uploads->transfers_[entry.path().filename()] = std::move(transfer);
  }
  return uploads;
}

Expected<UploadState> Uploads::open_transfer(const UploadRequest& request) {
  if (!is_sha256(request.sha256)) {
    return bad_input("'" + request.sha256 + "' is not a SHA-256 in 64 lower-case hex digits");
  }
  if (request.size_bytes == 0) return bad_input("a capture of 0 bytes cannot be uploaded");
  if (request.size_bytes > kLargestBytes) {
    return bad_input("an upload of " + std::to_string(request.size_bytes) +
                     " bytes is larger than the allowed " + std::to_string(kLargestBytes));
  }
  const std::string name =
      sha256_hex(request.user + "\n" + request.sha256 + "\n" + std::to_string(request.size_bytes))
          .substr(0, 32);
  const std::lock_guard lock(mutex_);
  auto& transfer = transfers_[name];
  if (!transfer) {
    auto fresh = std::make_shared<UploadTransfer>(folder_ / name, request);
    if (auto done = fresh->create(); !done) {
      transfers_.erase(name);
      return tl::unexpected(done.error());
    }
    transfer = std::move(fresh);
  }
  return transfer->state(name);
}

Expected<std::shared_ptr<UploadTransfer>> Uploads::find(const std::string& transfer) const {
  const std::lock_guard lock(mutex_);
  const auto found = transfers_.find(transfer);
  if (found == transfers_.end()) {
    return fail(ErrorKind::not_found, "there is no open transfer '" + transfer.substr(0, 64) + "'");
  }
  return found->second;
}

Expected<UploadProgress> Uploads::write_chunk(const std::string& transfer, std::uint64_t index,
                                              std::string_view bytes,
                                              std::optional<std::uint32_t> crc) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  auto progress = (*found)->write(index, bytes, crc ? *crc : crc32c(bytes.data(), bytes.size()));
  if (progress && (*found)->wants_sync()) helper_->look_at(*found);
  return progress;
}

Expected<UploadProgress> Uploads::sync(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  if (auto done = (*found)->sync(); !done) return tl::unexpected(done.error());
  return (*found)->progress_now();
}

Expected<UploadRequest> Uploads::request(const std::string& transfer) const {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  return (*found)->request();
}

Expected<fs::path> Uploads::seal(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  if (auto done = (*found)->close(); !done) return tl::unexpected(done.error());
  if (auto synced = (*found)->sync(); !synced) {  // which bytes are lost is not known: all again
    if (auto dropped = drop(transfer); !dropped) return tl::unexpected(dropped.error());
    return tl::unexpected(synced.error());
  }
  return (*found)->data_path();
}

Expected<void> Uploads::confirm(const std::string& transfer, const std::string& checksums) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  if (auto sealed = seal(transfer); !sealed) return tl::unexpected(sealed.error());
  if ((*found)->checksums() == checksums) {
    (*found)->confirm();
    return {};
  }
  if (auto done = drop(transfer); !done) return done;
  return bad_input("the uploaded chunks are not those of the file; the upload was dropped");
}

Expected<Uploads::Finished> Uploads::finish(const std::string& transfer,
                                            const std::string& sha256) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  UploadTransfer& it = **found;
  UploadRequest request = it.request();
  auto path = seal(transfer);
  if (!path) return tl::unexpected(path.error());
  const bool promised = !sha256.empty() || !it.confirmed();
  if (!sha256.empty()) request.sha256 = sha256;
  const auto hash = it.sha256();
  std::string message;
  if (!hash) {
    if (hash.error().kind != ErrorKind::bad_input) return tl::unexpected(hash.error());
    message = hash.error().message;
  } else if (promised && *hash != request.sha256) {
    message =
        "the uploaded bytes have the hash " + *hash + " instead of the promised " + request.sha256;
  } else {
    request.sha256 = *hash;
    return Finished{std::move(*path), std::move(request)};
  }
  if (auto done = drop(transfer); !done) return tl::unexpected(done.error());
  return bad_input(message + "; the upload was dropped");
}

Expected<void> Uploads::drop(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  (*found)->end();
  const std::lock_guard lock(mutex_);
  std::error_code error;
  fs::remove_all((*found)->folder(), error);
  transfers_.erase(transfer);
  if (error)
    return tl::unexpected<Error>(system_error((*found)->folder(), "removing", error.value()));
  return {};
}

std::uint64_t Uploads::pending_bytes(const std::string& user,
                                     const std::string& except_sha256) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& [name, transfer] : transfers_) {
    if (transfer->request().user == user && transfer->request().sha256 != except_sha256)
      sum += transfer->request().size_bytes;
  }
  return sum;
}

}  // namespace tenter::jobs
