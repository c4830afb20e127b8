// SPDX-License-Identifier: Apache-2.0
#include "client/api/upload.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <future>
#include <system_error>
#include <vector>

#include "client/api/json_body.h"
#include "common/base/sha256.h"
#include "common/wire/crc32c.h"
#include "common/wire/validate.h"

namespace tenter::client {

namespace v1 = wire::v1;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

// Below this a file is hashed before anything is sent, so that nothing is sent twice; above, while
// it is sent.
constexpr std::uint64_t kHashFirst = 8u << 20;
constexpr auto kSilence = std::chrono::milliseconds(1500);  // without an acknowledgement: ask

class File {
 public:
  explicit File(const fs::path& path) : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~File() {
    if (file_ >= 0) ::close(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  bool ok() const { return file_ >= 0; }
  bool read_at(std::uint64_t offset, std::vector<std::uint8_t>& data) const {
    std::size_t done = 0;
    while (done < data.size()) {
      const ssize_t got =
          ::pread(file_, data.data() + done, data.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      done += static_cast<std::size_t>(got);
    }
    return true;
  }

 private:
  int file_;
};

class Upload {
 public:
  Upload(Connection& connection, const fs::path& path, const TransferCallback& progress,
         const std::stop_token& stop)
      : connection_(connection), path_(path), file_(path), progress_(progress), stop_(stop) {}

  Expected<UploadResult> run();

 private:
  enum class Step { send, commit, done };

  Expected<std::string> stand_in() const;
  Expected<bool> already_known();

  Expected<Step> open();
  Expected<Step> send();
  Expected<Step> commit();
  Expected<void> connect(const wire::Uuid& transfer);
  void take(const v1::ChunkAck& ack);
  void tell();
  Error stopped() const { return {ErrorKind::cancelled, "the upload was stopped"}; }

  Connection& connection_;
  const fs::path path_;
  const File file_;
  const TransferCallback& progress_;
  const std::stop_token stop_;
  std::uint64_t size_ = 0;
  UploadResult result_;
  std::string name_;  ///< under which the transfer is opened: the hash, or a stand-in for it
  std::shared_future<Expected<std::string>> sha256_;
  bool asked_ = false;    ///< whether the server knows the hash
  bool resumed_ = false;  ///< some chunks came from an earlier upload
  std::uint64_t chunks_ = 0;
  std::vector<std::uint64_t> missing_;
  bool first_open_ = true;

  std::mutex mutex_;
  std::condition_variable_any acked_;
  wire::Uuid transfer_{};
  std::uint64_t written_ = 0;
  std::uint64_t credit_ = v1::CHUNK_WINDOW;
  std::uint32_t status_ = 0;
  std::string message_;

  std::unique_ptr<wire::Writer<v1::Chunk>> writer_;
  std::unique_ptr<wire::Reader<v1::ChunkAck>> acks_;
};

Expected<UploadResult> Upload::run() {
  std::error_code error;
  size_ = fs::file_size(path_, error);
  if (error || !file_.ok() || !fs::is_regular_file(path_))
    return fail(ErrorKind::not_found, path_.string() + ": cannot be read as a file");
  if (size_ == 0) return bad_input(path_.string() + ": the file is empty");
  result_.bytes_total = size_;
  sha256_ = std::async(std::launch::async, [path = path_] { return sha256_file(path); }).share();
  auto name = size_ < kHashFirst ? sha256_.get() : stand_in();
  if (!name) return tl::unexpected(name.error());
  name_ = *name;

  std::uint64_t best = 0;  // progress is a chunk written, or a step that ended
  auto since = Clock::now();
  for (;;) {
    auto step = open();
    if (step && *step == Step::send) step = send();
    if (step && *step == Step::commit) step = commit();
    if (!step) return tl::unexpected(step.error());
    if (*step == Step::done) {
      const auto& sha256 = sha256_.get();
      if (!sha256) return tl::unexpected(sha256.error());
      result_.sha256 = *sha256;
      return result_;
    }
    std::lock_guard lock(mutex_);
    if (written_ > best) {
      best = written_;
      since = Clock::now();
    }
    if (Clock::now() - since > connection_.options().timeout)
      return fail(ErrorKind::unavailable, path_.string() + ": the upload makes no progress; " +
                                              std::to_string(written_) + " of " +
                                              std::to_string(chunks_) + " chunks are there");
  }
}

// A name for a large file that costs nothing: its size, its time, its first and last megabyte. Two
// files with one name do no harm: the hash at the end tells them apart.
Expected<std::string> Upload::stand_in() const {
  std::error_code error;
  const auto time = fs::last_write_time(path_, error).time_since_epoch().count();
  std::vector<std::uint8_t> head(v1::CHUNK_BYTES), tail(v1::CHUNK_BYTES);
  if (error || !file_.read_at(0, head) || !file_.read_at(size_ - tail.size(), tail))
    return bad_input(path_.string() + ": became unreadable while it was sent");
  std::string text = std::to_string(size_) + ' ' + std::to_string(time) + ' ';
  text.append(head.begin(), head.end());
  text.append(tail.begin(), tail.end());
  return sha256_hex(text);
}

Expected<bool> Upload::already_known() {
  if (asked_ || sha256_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return false;
  asked_ = true;
  const auto& sha256 = sha256_.get();
  if (!sha256) return tl::unexpected(sha256.error());
  if (*sha256 == name_) return false;  // capture.open said so
  auto reply = ask(connection_, "capture.known", {{"sha256", *sha256}}, stop_);
  if (!reply) return tl::unexpected(reply.error());
  if (!flag_at(*reply, "already_stored")) return false;
  (void)ask(connection_, "capture.abandon", {{"transfer", wire::to_text(transfer_)}}, stop_);
  result_.already_stored = true;
  result_.summary_json = reply->value("capture", json::object()).dump();
  if (progress_) progress_({size_, size_, 0});
  return true;
}

Expected<Upload::Step> Upload::open() {
  auto reply = ask(connection_, "capture.open", {{"sha256", name_}, {"size", size_}}, stop_);
  if (!reply) return tl::unexpected(reply.error());
  if (flag_at(*reply, "already_stored")) {
    result_.already_stored = first_open_;
    result_.summary_json = reply->value("capture", json::object()).dump();
    if (progress_) progress_({size_, size_, first_open_ ? 0 : result_.bytes_resumed});
    return Step::done;
  }
  const auto transfer = wire::parse_uuid(text_at(*reply, "transfer"));
  chunks_ = count_at(*reply, "chunks");
  if (!transfer || chunks_ != (size_ + v1::CHUNK_BYTES - 1) / v1::CHUNK_BYTES)
    return fail(ErrorKind::internal, "the server's reply to capture.open does not fit the file");
  missing_.clear();
  for (const json& range : reply->value("missing", json::array())) {
    if (!range.is_array() || range.size() != 2 || !range[0].is_number_unsigned() ||
        !range[1].is_number_unsigned())
      return fail(ErrorKind::internal, "the server's reply to capture.open is not understood");
    const auto to = std::min(range[1].get<std::uint64_t>(), chunks_ - 1);
    for (auto i = range[0].get<std::uint64_t>(); i <= to; ++i) missing_.push_back(i);
  }
  if (*transfer != transfer_) {  // a server that was started anew names it anew
    writer_.reset();
    acks_.reset();
  }
  {
    std::lock_guard lock(mutex_);
    transfer_ = *transfer;
    written_ = std::max(chunks_ - missing_.size(), std::min(count_at(*reply, "written"), chunks_));
    status_ = 0;
    if (first_open_) result_.bytes_resumed = std::min(written_ * v1::CHUNK_BYTES, size_);
    resumed_ = first_open_ && written_ > 0;
  }
  first_open_ = false;
  tell();
  if (missing_.empty()) return Step::commit;
  if (auto connected = connect(*transfer); !connected) return tl::unexpected(connected.error());
  return Step::send;
}

Expected<void> Upload::connect(const wire::Uuid& transfer) {
  auto server = connection_.wait_for_server(stop_);
  if (!server) return tl::unexpected(server.error());
  if (!acks_) {
    wire::ReaderHandlers<v1::ChunkAck> handlers;
    handlers.on_sample = [this](v1::ChunkAck& ack, const wire::Peer&) { take(ack); };
    acks_ = std::make_unique<wire::Reader<v1::ChunkAck>>(
        connection_.participant(), wire::chunk_ack_topic(connection_.options().user, transfer),
        std::move(handlers));
  }
  if (!writer_)
    writer_ = std::make_unique<wire::Writer<v1::Chunk>>(
        connection_.participant(), wire::chunk_up_topic(connection_.options().user, transfer),
        [this](const wire::Peer&, bool) {
          std::lock_guard lock(mutex_);
          acked_.notify_all();
        });
  std::unique_lock lock(mutex_);
  const bool matched = acked_.wait_for(lock, stop_, connection_.options().timeout,
                                       [&] { return writer_->matched(server->peer); });
  if (!matched)
    return fail(ErrorKind::unavailable, "the server does not listen to the upload it opened");
  return {};
}

Expected<Upload::Step> Upload::send() {
  v1::Chunk chunk;
  chunk.transfer_id(transfer_);
  chunk.count(static_cast<std::uint32_t>(chunks_));
  std::uint64_t sent = 0;
  std::uint64_t written_at_start = 0;
  {
    std::lock_guard lock(mutex_);
    written_at_start = written_;
  }
  const auto in_flight = [&] {  // with mutex_
    const std::uint64_t done = written_ - std::min(written_, written_at_start);
    return sent - std::min(sent, done);
  };
  for (std::uint64_t index : missing_) {
    {
      std::unique_lock lock(mutex_);
      const bool room = acked_.wait_for(lock, stop_, kSilence,
                                        [&] { return status_ != 0 || in_flight() < credit_; });
      if (stop_.stop_requested()) return tl::unexpected(stopped());
      if (!room || status_ != 0) break;  // ask where we are
    }
    chunk.index(static_cast<std::uint32_t>(index));
    const std::uint64_t offset = index * v1::CHUNK_BYTES;
    chunk.data().resize(std::min<std::uint64_t>(v1::CHUNK_BYTES, size_ - offset));
    if (!file_.read_at(offset, chunk.data()))
      return bad_input(path_.string() + ": changed or became unreadable while it was sent");
    chunk.crc32c(wire::crc32c(chunk.data().data(), chunk.data().size()));
    if (auto written = writer_->write(chunk, std::chrono::milliseconds(2000)); !written) break;
    ++sent;
    tell();
    auto known = already_known();
    if (!known) return tl::unexpected(known.error());
    if (*known) return Step::done;
  }
  std::unique_lock lock(mutex_);
  std::uint64_t seen = written_;
  while (status_ == 0 && written_ < chunks_) {
    const bool news =
        acked_.wait_for(lock, stop_, kSilence, [&] { return status_ != 0 || written_ != seen; });
    if (stop_.stop_requested()) return tl::unexpected(stopped());
    if (!news) break;
    seen = written_;
    lock.unlock();
    tell();
    lock.lock();
  }
  if (status_ == static_cast<std::uint32_t>(ErrorKind::no_space) ||
      status_ == static_cast<std::uint32_t>(ErrorKind::bad_input) ||
      status_ == static_cast<std::uint32_t>(ErrorKind::refused))
    return fail(static_cast<ErrorKind>(status_), message_);
  return written_ >= chunks_ ? Step::commit : Step::send;
}

Expected<Upload::Step> Upload::commit() {
  const auto& sha256 = sha256_.get();
  if (!sha256) return tl::unexpected(sha256.error());
  auto reply = ask(connection_, "capture.commit",
                   {{"transfer", wire::to_text(transfer_)}, {"sha256", *sha256}}, stop_);
  if (!reply) {
    if (reply.error().kind == ErrorKind::not_found) return Step::send;  // the server began anew
    // chunks of another file that had the same stand-in: the server dropped them, send all
    if (reply.error().kind == ErrorKind::bad_input && resumed_) return Step::send;
    return tl::unexpected(reply.error());
  }
  result_.already_stored = !flag_at(*reply, "created");
  result_.summary_json = reply->value("capture", json::object()).dump();
  if (progress_) progress_({size_, size_, result_.bytes_resumed});
  return Step::done;
}

void Upload::take(const v1::ChunkAck& ack) {
  std::lock_guard lock(mutex_);
  if (ack.transfer_id() != transfer_) return;
  written_ = std::max<std::uint64_t>(written_, std::min<std::uint64_t>(ack.written(), chunks_));
  credit_ = std::max<std::uint64_t>(1, ack.credit());
  if (ack.status() != 0) {
    status_ = ack.status();
    message_ = ack.message();
  }
  acked_.notify_all();
}

void Upload::tell() {
  if (!progress_) return;
  std::uint64_t done = 0;
  {
    std::lock_guard lock(mutex_);
    done = std::min(written_ * v1::CHUNK_BYTES, size_);
  }
  progress_({done, size_, result_.bytes_resumed});
}

}  // namespace

Expected<UploadResult> upload(Connection& connection, const fs::path& path,
                              const TransferCallback& progress, const std::stop_token& stop) {
  return Upload(connection, path, progress, stop).run();
}

}  // namespace tenter::client
