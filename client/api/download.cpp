// SPDX-License-Identifier: Apache-2.0
#include "client/api/download.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <system_error>

#include "client/api/json_body.h"
#include "common/base/sha256.h"
#include "common/wire/validate.h"

namespace tenter::client {

namespace v1 = wire::v1;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

constexpr auto kPieceSilence = std::chrono::milliseconds(2000);

class Download {
 public:
  Download(Connection& connection, const RemoteFile& what, const fs::path& destination,
           const TransferCallback& progress, const std::stop_token& stop)
      : connection_(connection),
        what_(what),
        destination_(destination),
        progress_(progress),
        stop_(stop) {}
  ~Download() {
    if (file_ >= 0) ::close(file_);
    std::error_code ignored;
    if (!partial_.empty()) fs::remove(partial_, ignored);
  }
  Download(const Download&) = delete;
  Download& operator=(const Download&) = delete;

  Expected<std::uint64_t> run();

 private:
  struct Piece {
    std::uint32_t index;
    std::vector<std::uint8_t> data;
  };
  Expected<void> open_file();
  Expected<void> open_transfer();
  Expected<bool> fetch();  ///< false: begin anew for what is missing
  Expected<bool> ask_more(std::uint32_t from);
  Expected<void> write(const Piece& piece);
  Expected<std::uint64_t> finish();

  Connection& connection_;
  const RemoteFile what_;
  const fs::path destination_;
  const TransferCallback& progress_;
  const std::stop_token stop_;
  fs::path partial_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::string sha256_;
  std::vector<bool> have_;
  std::uint64_t bytes_ = 0;

  wire::Uuid transfer_{};
  std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::deque<Piece> pieces_;
  std::unique_ptr<wire::Reader<v1::Chunk>> reader_;
};

Expected<void> Download::open_file() {
  partial_ = destination_;
  partial_ += ".part-" + wire::to_text(wire::random_uuid()).substr(0, 8);
  file_ = ::open(partial_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0644);
  if (file_ >= 0) return {};
  const int number = errno;
  partial_.clear();
  return fail(number == ENOSPC ? ErrorKind::no_space : ErrorKind::bad_input,
              destination_.string() + ": cannot be written: " + std::strerror(number));
}

Expected<void> Download::open_transfer() {
  transfer_ = wire::random_uuid();
  wire::ReaderHandlers<v1::Chunk> handlers;
  handlers.on_sample = [this](v1::Chunk& chunk, const wire::Peer&) {
    std::lock_guard lock(mutex_);
    if (chunk.transfer_id() != transfer_ || pieces_.size() >= 2 * v1::CHUNK_WINDOW) return;
    pieces_.push_back({chunk.index(), std::move(chunk.data())});
    arrived_.notify_all();
  };
  reader_ = std::make_unique<wire::Reader<v1::Chunk>>(
      connection_.participant(), wire::chunk_down_topic(connection_.options().user, transfer_),
      std::move(handlers));
  json body = {{"transfer", wire::to_text(transfer_)}};
  if (!what_.capture.empty())
    body["capture"] = what_.capture;
  else
    body.update({{"job", what_.job_id}, {"file", what_.file}});
  auto reply = ask(connection_, "file.open", body, stop_);
  if (!reply) return tl::unexpected(reply.error());
  const std::string sha256 = text_at(*reply, "sha256");
  const std::uint64_t size = count_at(*reply, "size");
  const std::uint64_t chunks = count_at(*reply, "chunks");
  if (!is_sha256(sha256) || chunks != (size + v1::CHUNK_BYTES - 1) / v1::CHUNK_BYTES ||
      chunks > v1::MAX_CHUNK_COUNT)
    return fail(ErrorKind::internal, "the server's reply to file.open is not understood");
  if (sha256 != sha256_ || size != size_) {  // the first time, or another file by now
    sha256_ = sha256;
    size_ = size;
    have_.assign(chunks, false);
    bytes_ = 0;
    if (::ftruncate(file_, 0) != 0)
      return fail(ErrorKind::internal, partial_.string() + ": " + std::strerror(errno));
  }
  return {};
}

Expected<bool> Download::ask_more(std::uint32_t from) {
  auto reply =
      ask(connection_, "file.more",
          {{"transfer", wire::to_text(transfer_)}, {"from", from}, {"count", v1::CHUNK_ACK_EVERY}},
          stop_);
  if (reply) return true;
  const ErrorKind kind = reply.error().kind;
  if (kind == ErrorKind::not_found || kind == ErrorKind::unavailable) return false;
  return tl::unexpected(reply.error());
}

Expected<void> Download::write(const Piece& piece) {
  if (piece.index >= have_.size() || have_[piece.index]) return {};
  const std::uint64_t offset = std::uint64_t{piece.index} * v1::CHUNK_BYTES;
  std::size_t done = 0;
  while (done < piece.data.size()) {
    const ssize_t put = ::pwrite(file_, piece.data.data() + done, piece.data.size() - done,
                                 static_cast<off_t>(offset + done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0)
      return fail(errno == ENOSPC ? ErrorKind::no_space : ErrorKind::internal,
                  partial_.string() + ": cannot be written: " + std::strerror(errno));
    done += static_cast<std::size_t>(put);
  }
  have_[piece.index] = true;
  bytes_ += piece.data.size();
  if (progress_) progress_({bytes_, size_, 0});
  return {};
}

Expected<bool> Download::fetch() {
  const auto first_missing = [this](std::size_t from) {
    while (from < have_.size() && have_[from]) ++from;
    return static_cast<std::uint32_t>(from);
  };
  std::uint32_t asked = first_missing(0);  // everything below was asked for
  std::uint32_t next = asked;              // everything below is here
  while (next < have_.size()) {
    while (asked < have_.size() && asked < next + v1::CHUNK_WINDOW) {
      auto going = ask_more(asked);
      if (!going || !*going) return going;
      asked += v1::CHUNK_ACK_EVERY;
    }
    Piece piece;
    {
      std::unique_lock lock(mutex_);
      const bool came =
          arrived_.wait_for(lock, stop_, kPieceSilence, [this] { return !pieces_.empty(); });
      if (stop_.stop_requested()) return fail(ErrorKind::cancelled, "the download was stopped");
      if (!came) return false;
      piece = std::move(pieces_.front());
      pieces_.pop_front();
    }
    if (auto written = write(piece); !written) return tl::unexpected(written.error());
    next = first_missing(next);
  }
  return true;
}

Expected<std::uint64_t> Download::finish() {
  auto sha256 = sha256_file(partial_);
  if (!sha256) return tl::unexpected(sha256.error());
  if (*sha256 != sha256_)
    return fail(ErrorKind::internal, destination_.string() +
                                         ": what arrived does not have the SHA-256 that the "
                                         "server named");
  std::error_code error;
  fs::rename(partial_, destination_, error);
  if (error) return bad_input(destination_.string() + ": cannot be written: " + error.message());
  partial_.clear();
  return size_;
}

Expected<std::uint64_t> Download::run() {
  if (auto opened = open_file(); !opened) return tl::unexpected(opened.error());
  std::uint64_t best = 0;
  auto since = Clock::now();
  for (;;) {
    if (auto opened = open_transfer(); !opened) return tl::unexpected(opened.error());
    auto complete = fetch();
    if (!complete) return tl::unexpected(complete.error());
    (void)ask(connection_, "file.close", {{"transfer", wire::to_text(transfer_)}}, stop_);
    if (*complete) return finish();
    reader_.reset();
    pieces_.clear();
    if (bytes_ > best) {
      best = bytes_;
      since = Clock::now();
    }
    if (Clock::now() - since > connection_.options().timeout)
      return fail(ErrorKind::unavailable,
                  destination_.string() + ": the download makes no progress");
  }
}

}  // namespace

Expected<std::uint64_t> download(Connection& connection, const RemoteFile& what,
                                 const fs::path& destination, const TransferCallback& progress,
                                 const std::stop_token& stop) {
  return Download(connection, what, destination, progress, stop).run();
}

}  // namespace tenter::client
