// SPDX-License-Identifier: Apache-2.0
#include "client/api/upload.h"

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "client/api/json_body.h"
#include "client/api/upload_file.h"
#include "common/base/sha256.h"
#include "common/wire/validate.h"

namespace tenter::client {

namespace v1 = wire::v1;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

// Below this a file is hashed before anything is sent, so that nothing is sent twice. Above it the
// server names it: each chunk has its checksum, the list of them says whose they are, and no fault
// on the way passes those two. A hash of the whole is worth its time only where sending takes
// longer than hashing: then it may show that the server has the file.
constexpr std::uint64_t kHashFirst = 8u << 20;
constexpr double kLookAfter = 0.5;      // seconds of sending, before how fast it is can be said
constexpr double kHashBytesPerS = 1e9;  // at least
constexpr auto kAckSilence = std::chrono::milliseconds(1500);  // without an acknowledgement: ask

class Upload {
 public:
  Upload(Connection& connection, const fs::path& path, const TransferCallback& progress,
         const std::stop_token& stop)
      : connection_(connection), file_(path), progress_(progress), stop_(stop) {}

  Expected<UploadResult> run();

 private:
  enum class Step { send, store, commit, done };

  Expected<bool> already_known();
  void hash_if_slow();

  Expected<Step> open();
  Expected<Step> send();
  Expected<Step> store();
  Expected<Step> commit();
  Expected<Step> accept(const json& reply, bool created);
  Expected<void> connect(const wire::Uuid& transfer);
  void take(const v1::ChunkAck& ack);
  void tell();
  Error stopped() const { return {ErrorKind::cancelled, "the upload was stopped"}; }

  Connection& connection_;
  UploadFile file_;
  const TransferCallback& progress_;
  const std::stop_token stop_;
  std::uint64_t size_ = 0;
  UploadResult result_;
  std::string name_;    ///< under which the transfer is opened: the hash, or a stand-in for it
  std::string sha256_;  ///< "": not known
  bool stored_ = false;
  bool resumed_ = false;  ///< some chunks came from an earlier upload
  std::uint64_t chunks_ = 0;
  std::vector<std::uint64_t> missing_;
  bool first_open_ = true;
  Clock::time_point send_start_;
  std::uint64_t written_at_start_ = 0;
  std::uint64_t best_ = 0;  ///< progress is more chunks written than ever before

  std::mutex mutex_;
  std::condition_variable_any acked_;
  wire::Uuid transfer_{};
  std::uint64_t written_ = 0;
  std::uint64_t credit_ = v1::CHUNK_WINDOW;
  std::uint32_t status_ = 0;
  std::string message_;

  std::unique_ptr<wire::Writer<v1::Chunk>> writer_;
  std::unique_ptr<wire::Reader<v1::ChunkAck>> acks_;
  std::optional<HashBeside> hash_beside_;  ///< reads file_
};

Expected<UploadResult> Upload::run() {
  if (auto opened = file_.open(); !opened) return tl::unexpected(opened.error());
  size_ = result_.bytes_total = file_.size();
  chunks_ = file_.chunks();
  auto name = size_ < kHashFirst ? file_.sha256({}) : file_.stand_in();
  if (!name) return tl::unexpected(name.error());
  name_ = *name;
  if (size_ < kHashFirst) sha256_ = name_;

  auto since = Clock::now();
  for (;;) {
    auto step = open();
    if (step && *step == Step::send) step = send();
    if (step && *step == Step::store) step = store();
    if (step && *step == Step::commit) step = commit();
    if (!step) return tl::unexpected(step.error());
    if (*step == Step::done) return result_;
    std::lock_guard lock(mutex_);
    if (written_ > best_) {
      best_ = written_;
      since = Clock::now();
    }
    if (Clock::now() - since > connection_.options().timeout)
      return fail(ErrorKind::unavailable, file_.path().string() +
                                              ": the upload makes no progress; " +
                                              std::to_string(written_) + " of " +
                                              std::to_string(chunks_) + " chunks are there");
  }
}

void Upload::hash_if_slow() {
  if (!sha256_.empty() || hash_beside_) return;
  const double so_far = std::chrono::duration<double>(Clock::now() - send_start_).count();
  if (so_far < kLookAfter) return;
  std::uint64_t chunks = 0, left = 0;
  {
    std::lock_guard lock(mutex_);
    chunks = written_ - std::min(written_, written_at_start_);
    left = chunks_ - written_;
  }
  const double rest = so_far * static_cast<double>(left) / static_cast<double>(chunks + 1);
  if (rest > static_cast<double>(size_) / kHashBytesPerS) hash_beside_.emplace(file_);
}

Expected<bool> Upload::already_known() {
  if (!sha256_.empty() || !hash_beside_) return false;
  sha256_ = hash_beside_->known();
  if (sha256_.empty()) return false;
  auto reply = ask(connection_, "capture.known", {{"sha256", sha256_}}, stop_);
  if (!reply) return tl::unexpected(reply.error());
  if (!flag_at(*reply, "already_stored")) return false;
  (void)ask(connection_, "capture.abandon", {{"transfer", wire::to_text(transfer_)}}, stop_);
  if (auto step = accept(*reply, false); !step) return tl::unexpected(step.error());
  return true;
}

Expected<Upload::Step> Upload::open() {
  auto reply = ask(connection_, "capture.open", {{"sha256", name_}, {"size", size_}}, stop_);
  if (!reply) return tl::unexpected(reply.error());
  if (flag_at(*reply, "already_stored")) {
    return accept(*reply, !first_open_);
  }
  const auto transfer = wire::parse_uuid(text_at(*reply, "transfer"));
  if (!transfer || count_at(*reply, "chunks") != chunks_)
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
    stored_ = false;
    if (first_open_) result_.bytes_resumed = std::min(written_ * v1::CHUNK_BYTES, size_);
    resumed_ = first_open_ && written_ > 0;
  }
  first_open_ = false;
  tell();
  if (missing_.empty()) return Step::store;
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
  ReadAhead ahead(file_, missing_, transfer_);
  std::uint64_t sent = 0;
  {
    std::lock_guard lock(mutex_);
    written_at_start_ = written_;
  }
  send_start_ = Clock::now();
  const auto in_flight = [&] {  // with mutex_
    const std::uint64_t done = written_ - std::min(written_, written_at_start_);
    return sent - std::min(sent, done);
  };
  for (;;) {
    auto chunk = ahead.next();
    if (!chunk) return tl::unexpected(chunk.error());
    if (!*chunk) break;
    {
      std::unique_lock lock(mutex_);
      const bool room = acked_.wait_for(lock, stop_, kAckSilence,
                                        [&] { return status_ != 0 || in_flight() < credit_; });
      if (stop_.stop_requested()) return tl::unexpected(stopped());
      if (!room || status_ != 0) break;  // ask where we are
    }
    if (auto written = writer_->write(**chunk, std::chrono::milliseconds(2000)); !written) break;
    ++sent;
    tell();
    hash_if_slow();
    auto known = already_known();
    if (!known) return tl::unexpected(known.error());
    if (*known) return Step::done;
  }
  std::unique_lock lock(mutex_);
  std::uint64_t seen = written_;
  while (status_ == 0 && written_ < chunks_) {
    const bool news =
        acked_.wait_for(lock, stop_, kAckSilence, [&] { return status_ != 0 || written_ != seen; });
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
  return written_ >= chunks_ ? Step::store : Step::send;
}

// The reply says that the bytes are on the server's disk.
Expected<Upload::Step> Upload::store() {
  if (hash_beside_) hash_beside_->stop();
  auto checksums = file_.checksums();
  if (!checksums) return tl::unexpected(checksums.error());
  auto reply = ask(connection_, "capture.store",
                   {{"transfer", wire::to_text(transfer_)}, {"chunks_sha256", *checksums}}, stop_);
  if (!reply) {
    if (reply.error().kind == ErrorKind::not_found) return Step::send;  // the server began anew
    // chunks of another file that had the same stand-in: the server dropped them, send all
    if (reply.error().kind == ErrorKind::bad_input && resumed_) {
      best_ = 0;
      return Step::send;
    }
    return tl::unexpected(reply.error());
  }
  stored_ = true;
  tell();
  return Step::commit;
}

// The reply says that it is a good capture and in the list.
Expected<Upload::Step> Upload::commit() {
  json body = {{"transfer", wire::to_text(transfer_)}};
  if (!sha256_.empty()) body["sha256"] = sha256_;
  auto reply = ask(connection_, "capture.commit", body, stop_);
  if (!reply) {
    if (reply.error().kind == ErrorKind::not_found) return Step::send;  // the server began anew
    return tl::unexpected(reply.error());
  }
  return accept(*reply, flag_at(*reply, "created"));
}

Expected<Upload::Step> Upload::accept(const json& reply, bool created) {
  const json capture = reply.value("capture", json::object());
  result_.already_stored = !created;
  result_.sha256 = text_at(capture, "id");
  result_.summary_json = capture.dump();
  if (!is_sha256(result_.sha256) || (!sha256_.empty() && result_.sha256 != sha256_))
    return fail(ErrorKind::internal, "the server's reply names another capture");
  stored_ = true;
  if (progress_) progress_({size_, size_, result_.bytes_resumed, stored_});
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
  progress_({done, size_, result_.bytes_resumed, stored_});
}

}  // namespace

Expected<UploadResult> upload(Connection& connection, const fs::path& path,
                              const TransferCallback& progress, const std::stop_token& stop) {
  return Upload(connection, path, progress, stop).run();
}

}  // namespace tenter::client
