// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/download_endpoint.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/crc32c.h"
#include "common/wire/validate.h"
#include "server/service/body.h"

namespace tenter::service {

namespace v1 = wire::v1;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

namespace {

constexpr auto kForget = std::chrono::seconds(60);
constexpr auto kWriteDeadline = std::chrono::milliseconds(500);

Expected<wire::Uuid> transfer_of(const json& body) {
  auto text = required_text(body, "transfer");
  if (!text) return tl::unexpected(text.error());
  const auto id = wire::parse_uuid(*text);
  if (!id || *id == wire::Uuid{})
    return bad_input("the request's \"transfer\" is not an identifier");
  return *id;
}

Expected<void> read_at(int file, std::uint64_t offset, std::vector<std::uint8_t>& data) {
  std::size_t done = 0;
  while (done < data.size()) {
    const ssize_t got =
        ::pread(file, data.data() + done, data.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return fail(ErrorKind::internal,
                  std::string("the stored file cannot be read: ") +
                      (got < 0 ? std::strerror(errno) : "it is shorter than it was"));
    done += static_cast<std::size_t>(got);
  }
  return {};
}

}  // namespace

struct DownloadEndpoint::Transfer {
  ~Transfer() {
    if (file >= 0) ::close(file);
  }
  std::string user;
  int file = -1;
  std::uint64_t size = 0;
  std::uint32_t chunks = 0;
  std::mutex mutex;  ///< one portion at a time
  Clock::time_point last_seen = Clock::now();
  std::unique_ptr<wire::Writer<v1::Chunk>> writer;
};

DownloadEndpoint::DownloadEndpoint(const Context& context, jobs::JobService& jobs)
    : context_(context), jobs_(jobs) {}

DownloadEndpoint::~DownloadEndpoint() {
  context_.participant.loop().run([this] { transfers_.clear(); });
}

void DownloadEndpoint::add_operations(Operations& table) {
  table["file.open"] = {[this](const Caller& c, const json& b) { return open(c, b); }, true};
  table["file.more"] = {[this](const Caller& c, const json& b) { return more(c, b); }, true};
  table["file.close"] = {[this](const Caller& c, const json& b) { return close(c, b); }, true};
}

Expected<jobs::StoredFile> DownloadEndpoint::file_of(const json& body) {
  auto capture = optional_text(body, "capture");
  if (!capture) return tl::unexpected(capture.error());
  if (*capture) return jobs_.capture_file(**capture);
  auto job = required_job(body, "job");
  if (!job) return tl::unexpected(job.error());
  auto name = required_text(body, "file");
  if (!name) return tl::unexpected(name.error());
  if (*name == "result.json") return jobs_.result(*job);
  if (*name == "residuals.h5") return jobs_.residuals(*job);
  if (*name == "frames.h5") return jobs_.frames(*job);
  return bad_input("the request's \"file\" is '" + *name +
                   "', not result.json, residuals.h5 or frames.h5");
}

Expected<json> DownloadEndpoint::open(const Caller& caller, const json& body) {
  auto id = transfer_of(body);
  if (!id) return tl::unexpected(id.error());
  auto stored = file_of(body);
  if (!stored) return tl::unexpected(stored.error());
  {
    std::lock_guard lock(mutex_);
    const auto of_user = std::count_if(transfers_.begin(), transfers_.end(), [&](const auto& t) {
      return t.second->user == caller.user;
    });
    if (of_user >= wire::kMaxTransfers)
      return fail(ErrorKind::refused, "user " + caller.user + " has " + std::to_string(of_user) +
                                          " downloads under way; try again when one has ended");
    if (transfers_.count(*id) > 0)
      return fail(ErrorKind::refused, "the transfer " + wire::to_text(*id) + " is open already");
  }
  auto transfer = std::make_shared<Transfer>();
  transfer->user = caller.user;
  transfer->size = stored->size_bytes;
  transfer->chunks =
      static_cast<std::uint32_t>((stored->size_bytes + v1::CHUNK_BYTES - 1) / v1::CHUNK_BYTES);
  transfer->file = ::open(stored->path.c_str(), O_RDONLY | O_CLOEXEC);
  if (transfer->file < 0)
    return fail(ErrorKind::internal,
                std::string("the stored file cannot be opened: ") + std::strerror(errno));
  transfer->writer = std::make_unique<wire::Writer<v1::Chunk>>(
      context_.participant, wire::chunk_down_topic(caller.user, *id), wire::MatchHandler{},
      context_.epoch);
  {
    std::lock_guard lock(mutex_);
    transfers_[*id] = transfer;
  }
  return json{{"size", transfer->size},
              {"sha256", stored->sha256},
              {"chunks", transfer->chunks},
              {"chunk_bytes", v1::CHUNK_BYTES}};
}

Expected<json> DownloadEndpoint::more(const Caller& caller, const json& body) {
  auto id = transfer_of(body);
  if (!id) return tl::unexpected(id.error());
  auto from = required_integer(body, "from", 0, v1::MAX_CHUNK_COUNT);
  if (!from) return tl::unexpected(from.error());
  auto count = required_integer(body, "count", 1, v1::CHUNK_ACK_EVERY);
  if (!count) return tl::unexpected(count.error());
  std::shared_ptr<Transfer> transfer;
  {
    std::lock_guard lock(mutex_);
    const auto found = transfers_.find(*id);
    if (found == transfers_.end() || found->second->user != caller.user)
      return fail(ErrorKind::not_found,
                  "there is no transfer " + wire::to_text(*id) + "; open it again");
    transfer = found->second;
  }
  std::lock_guard lock(transfer->mutex);
  transfer->last_seen = Clock::now();
  const auto first = static_cast<std::uint32_t>(*from);
  const auto end = std::min(first + static_cast<std::uint32_t>(*count), transfer->chunks);
  v1::Chunk chunk;
  chunk.transfer_id(*id);
  chunk.count(transfer->chunks);
  for (std::uint32_t index = first; index < end; ++index) {
    const std::uint64_t offset = std::uint64_t{index} * v1::CHUNK_BYTES;
    chunk.index(index);
    chunk.data().resize(std::min<std::uint64_t>(v1::CHUNK_BYTES, transfer->size - offset));
    if (auto read = read_at(transfer->file, offset, chunk.data()); !read)
      return tl::unexpected(read.error());
    chunk.crc32c(crc32c(chunk.data().data(), chunk.data().size()));
    if (auto sent = transfer->writer->write(chunk, kWriteDeadline); !sent)
      return tl::unexpected(sent.error());
  }
  return json{{"sent", end > first ? end - first : 0}};
}

Expected<json> DownloadEndpoint::close(const Caller& caller, const json& body) {
  auto id = transfer_of(body);
  if (!id) return tl::unexpected(id.error());
  std::shared_ptr<Transfer> transfer;
  std::lock_guard lock(mutex_);
  const auto found = transfers_.find(*id);
  if (found == transfers_.end() || found->second->user != caller.user) return json::object();
  transfer = std::move(found->second);
  transfers_.erase(found);
  return json::object();
}

void DownloadEndpoint::tidy() {
  const auto now = Clock::now();
  std::vector<std::shared_ptr<Transfer>> ended;
  std::lock_guard lock(mutex_);
  for (auto one = transfers_.begin(); one != transfers_.end();) {
    if (std::unique_lock portion(one->second->mutex, std::try_to_lock);
        portion && now - one->second->last_seen > kForget) {
      portion.unlock();
      ended.push_back(std::move(one->second));
      one = transfers_.erase(one);
    } else {
      ++one;
    }
  }
}

}  // namespace tenter::service
