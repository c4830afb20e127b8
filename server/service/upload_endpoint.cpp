// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/upload_endpoint.h"

#include <malloc.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/sha256.h"
#include "common/wire/validate.h"
#include "server/service/body.h"

namespace tenter::service {

namespace v1 = wire::v1;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

namespace {

constexpr auto kForget = std::chrono::seconds(60);
constexpr int kQueued = 2 * static_cast<int>(v1::CHUNK_WINDOW);

// [[from, to], ...], both inclusive, of what is not there.
json missing_ranges(const std::vector<bool>& present) {
  json ranges = json::array();
  for (std::size_t i = 0; i < present.size(); ++i) {
    if (present[i]) continue;
    if (!ranges.empty() && ranges.back()[1] == i - 1)
      ranges.back()[1] = i;
    else
      ranges.push_back({i, i});
  }
  return ranges;
}

}  // namespace

std::vector<std::uint8_t> UploadEndpoint::Buffers::take() {
  std::lock_guard lock(mutex_);
  if (kept_.empty()) return {};
  auto buffer = std::move(kept_.back());
  kept_.pop_back();
  return buffer;
}

void UploadEndpoint::Buffers::put(std::vector<std::uint8_t> buffer) {
  std::lock_guard lock(mutex_);
  if (kept_.size() < v1::CHUNK_WINDOW) kept_.push_back(std::move(buffer));
}

void UploadEndpoint::Buffers::clear() {
  std::lock_guard lock(mutex_);
  kept_ = {};
}

struct UploadEndpoint::Transfer {
  std::string name;  ///< as the queue calls it
  wire::Uuid id{};
  std::string lane;  ///< its key in the queue
  std::string user;
  std::uint64_t chunks = 0;

  std::mutex mutex;
  int queued = 0;
  int since_ack = 0;
  std::uint64_t written = 0;
  bool failed = false;
  Clock::time_point last_seen = Clock::now();
  std::unique_ptr<wire::Writer<v1::ChunkAck>> acks;
  std::unique_ptr<wire::Reader<v1::Chunk>> reader;  ///< last: gone first
};

UploadEndpoint::UploadEndpoint(const Context& context, jobs::JobService& jobs)
    : context_(context),
      jobs_(jobs),
      queue_(std::make_unique<WorkQueue>(
          WorkQueue::Limits{.threads = 2, .per_key = kQueued, .total = 16 * kQueued})) {}

UploadEndpoint::~UploadEndpoint() {
  queue_.reset();
  context_.participant.loop().run([this] { transfers_.clear(); });
}

void UploadEndpoint::add_operations(Operations& table) {
  table["capture.open"] = {[this](const Caller& c, const json& b) { return open(c, b); }, true};
  table["capture.store"] = {[this](const Caller& c, const json& b) { return store(c, b); }, true};
  table["capture.commit"] = {[this](const Caller& c, const json& b) { return commit(c, b); }, true};
  table["capture.known"] = {[this](const Caller&, const json& b) { return known(b); }, true};
  table["capture.abandon"] = {[this](const Caller& c, const json& b) { return abandon(c, b); },
                              true};
}

Expected<json> UploadEndpoint::open(const Caller& caller, const json& body) {
  auto sha256 = required_text(body, "sha256");
  if (!sha256) return tl::unexpected(sha256.error());
  constexpr std::int64_t kLargest = std::int64_t{v1::CHUNK_BYTES} * v1::MAX_CHUNK_COUNT;
  auto size = required_integer(body, "size", 1, kLargest);
  if (!size) return tl::unexpected(size.error());
  auto state = jobs_.upload_open({caller.user, *sha256, static_cast<std::uint64_t>(*size)});
  if (!state) return tl::unexpected(state.error());
  if (state->already_stored) {
    auto capture = jobs_.capture(*sha256);
    if (!capture) return tl::unexpected(capture.error());
    return json{{"already_stored", true}, {"capture", to_json(*capture)}};
  }

  // After a restart it has another name: on the old topic the reader that was killed with the last
  // daemon holds up the client until its lease ends.
  const wire::Uuid id = wire::uuid_of(state->transfer + ' ' + std::to_string(context_.epoch));
  std::shared_ptr<Transfer> transfer;
  {
    std::lock_guard lock(mutex_);
    const auto found = transfers_.find(id);
    if (found != transfers_.end()) {
      transfer = found->second;
      std::lock_guard inner(transfer->mutex);
      transfer->last_seen = Clock::now();
      transfer->failed = false;
    } else {
      const auto of_user = std::count_if(transfers_.begin(), transfers_.end(), [&](const auto& t) {
        return t.second->user == caller.user;
      });
      if (of_user >= wire::kMaxTransfers)
        return fail(ErrorKind::refused, "user " + caller.user + " has " + std::to_string(of_user) +
                                            " uploads under way; try again when one has ended");
    }
  }
  if (!transfer) {
    transfer = std::make_shared<Transfer>();
    transfer->name = state->transfer;
    transfer->id = id;
    transfer->lane = wire::to_text(id);
    transfer->user = caller.user;
    transfer->chunks = state->chunks;
    transfer->acks = std::make_unique<wire::Writer<v1::ChunkAck>>(
        context_.participant, wire::chunk_ack_topic(caller.user, id), wire::MatchHandler{},
        context_.epoch);
    wire::ReaderHandlers<v1::Chunk> handlers;
    handlers.on_sample = [this, weak = std::weak_ptr(transfer)](v1::Chunk& chunk,
                                                                const wire::Peer&) {
      auto strong = weak.lock();
      if (!strong) return;
      take(strong, chunk);
      // if this is the last hold on it, it must not end inside its own reader's handler
      context_.participant.loop().post([held = std::move(strong)] {});
    };
    transfer->reader = std::make_unique<wire::Reader<v1::Chunk>>(
        context_.participant, wire::chunk_up_topic(caller.user, id), std::move(handlers));
    std::lock_guard lock(mutex_);
    transfers_.try_emplace(id, transfer);
  }
  const auto written =
      static_cast<std::uint64_t>(std::count(state->present.begin(), state->present.end(), true));
  {
    std::lock_guard inner(transfer->mutex);
    transfer->written = std::max(transfer->written, written);
  }
  acknowledge(*transfer, 0, "");  // takes the place of an older one that said it failed
  return json{{"already_stored", false},
              {"transfer", wire::to_text(id)},
              {"chunk_bytes", state->chunk_bytes},
              {"chunks", state->chunks},
              {"written", written},
              {"credit", v1::CHUNK_WINDOW},
              {"missing", missing_ranges(state->present)}};
}

// Loop thread: only hands over.
void UploadEndpoint::take(const std::shared_ptr<Transfer>& transfer, v1::Chunk& chunk) {
  if (chunk.transfer_id() != transfer->id || chunk.count() != transfer->chunks) return;
  {
    std::lock_guard lock(transfer->mutex);
    transfer->last_seen = Clock::now();
    if (transfer->failed || transfer->queued >= kQueued) return;
    ++transfer->queued;
  }
  const std::uint64_t index = chunk.index();
  const std::uint32_t crc = chunk.crc32c();  // which the validator found right
  auto data = std::make_shared<std::vector<std::uint8_t>>(spare_.take());
  data->swap(chunk.data());
  const bool taken = queue_->add(transfer->lane, [this, transfer, index, crc, data] {
    write(transfer, index, crc, *data);
    spare_.put(std::move(*data));
  });
  if (!taken) {
    std::lock_guard lock(transfer->mutex);
    --transfer->queued;
  }
}

// A thread of the queue; of one transfer one at a time.
void UploadEndpoint::write(const std::shared_ptr<Transfer>& transfer, std::uint64_t index,
                           std::uint32_t crc, const std::vector<std::uint8_t>& data) {
  auto progress = jobs_.upload_chunk(
      transfer->name, index, {reinterpret_cast<const char*>(data.data()), data.size()}, crc);
  bool tell = false;
  {
    std::lock_guard lock(transfer->mutex);
    --transfer->queued;
    ++transfer->since_ack;
    if (progress) {
      transfer->written = progress->received;
      tell = transfer->since_ack >= static_cast<int>(v1::CHUNK_ACK_EVERY) || transfer->queued == 0;
    } else {
      tell = !transfer->failed;
      transfer->failed = true;
    }
    if (tell) transfer->since_ack = 0;
  }
  if (!tell) return;
  if (progress)
    acknowledge(*transfer, 0, "");
  else
    acknowledge(*transfer, static_cast<std::uint32_t>(progress.error().kind),
                progress.error().message);
}

void UploadEndpoint::acknowledge(Transfer& transfer, std::uint32_t status,
                                 const std::string& message) {
  v1::ChunkAck ack;
  ack.transfer_id(transfer.id);
  {
    std::lock_guard lock(transfer.mutex);
    ack.written(static_cast<std::uint32_t>(transfer.written));
  }
  ack.credit(v1::CHUNK_WINDOW);
  ack.status(status);
  ack.message(wire::clean_text(message, v1::MAX_TEXT));
  if (auto sent = transfer.acks->write(ack); !sent)
    context_.log(Level::warning, sent.error().message);
}

Expected<std::shared_ptr<UploadEndpoint::Transfer>> UploadEndpoint::find(const Caller& caller,
                                                                         const json& body) {
  auto text = required_text(body, "transfer");
  if (!text) return tl::unexpected(text.error());
  const auto id = wire::parse_uuid(*text);
  if (!id) return bad_input("the request's \"transfer\" is not an identifier");
  std::lock_guard lock(mutex_);
  const auto found = transfers_.find(*id);
  if (found == transfers_.end() || found->second->user != caller.user)
    return fail(ErrorKind::not_found, "there is no transfer " + *text + "; open it again");
  return found->second;
}

Expected<json> UploadEndpoint::store(const Caller& caller, const json& body) {
  auto transfer = find(caller, body);
  if (!transfer) return tl::unexpected(transfer.error());
  auto checksums = required_text(body, "chunks_sha256");
  if (!checksums) return tl::unexpected(checksums.error());
  if (!is_sha256(*checksums))
    return bad_input("the request's \"chunks_sha256\" is not 64 lower-case hex digits");
  if (auto done = jobs_.upload_store((*transfer)->name, *checksums); !done) {
    if (done.error().kind == ErrorKind::bad_input) close((*transfer)->id);
    return tl::unexpected(done.error());
  }
  return json{{"stored", true}};
}

Expected<json> UploadEndpoint::commit(const Caller& caller, const json& body) {
  auto transfer = find(caller, body);
  if (!transfer) return tl::unexpected(transfer.error());
  auto sha256 = optional_text(body, "sha256");
  if (!sha256) return tl::unexpected(sha256.error());
  if (*sha256 && !is_sha256(**sha256))
    return bad_input("the request's \"sha256\" is not 64 lower-case hex digits");
  auto done = jobs_.upload_commit((*transfer)->name, sha256->value_or(""));
  if (!done) {
    // a bad hash or a bad file ended it; what can go on (chunks missing, disk full) is opened again
    if (done.error().kind == ErrorKind::bad_input) close((*transfer)->id);
    return tl::unexpected(done.error());
  }
  close((*transfer)->id);
  return json{{"capture", to_json(done->capture)}, {"created", done->created}};
}

Expected<json> UploadEndpoint::known(const json& body) {
  auto sha256 = required_text(body, "sha256");
  if (!sha256) return tl::unexpected(sha256.error());
  auto capture = jobs_.capture(*sha256);
  const bool there = capture && jobs_.capture_file(*sha256);  // its row and its bytes
  return json{{"already_stored", there}, {"capture", there ? to_json(*capture) : json()}};
}

Expected<json> UploadEndpoint::abandon(const Caller& caller, const json& body) {
  auto transfer = find(caller, body);
  if (!transfer) return tl::unexpected(transfer.error());
  if (auto done = jobs_.upload_abandon((*transfer)->name); !done)
    return tl::unexpected(done.error());
  close((*transfer)->id);
  return json::object();
}

void UploadEndpoint::close(const wire::Uuid& id) {
  std::shared_ptr<Transfer> transfer;
  bool last = false;
  {
    std::lock_guard lock(mutex_);
    const auto found = transfers_.find(id);
    if (found == transfers_.end()) return;
    transfer = std::move(found->second);
    transfers_.erase(found);
    last = transfers_.empty();
  }
  transfer.reset();
  if (last) give_back();
}

// The histories and buffers of transfers are large: an idle daemon is to be small again.
void UploadEndpoint::give_back() {
  spare_.clear();
  ::malloc_trim(0);
}

void UploadEndpoint::tidy() {
  const auto now = Clock::now();
  std::vector<std::shared_ptr<Transfer>> ended;
  bool last = false;
  {
    std::lock_guard lock(mutex_);
    for (auto one = transfers_.begin(); one != transfers_.end();) {
      Transfer& transfer = *one->second;
      bool forget = false;
      {
        std::lock_guard inner(transfer.mutex);
        forget = transfer.queued == 0 && now - transfer.last_seen > kForget;
      }
      if (forget) {
        ended.push_back(std::move(one->second));
        one = transfers_.erase(one);
      } else {
        ++one;
      }
    }
    last = !ended.empty() && transfers_.empty();
  }
  ended.clear();
  if (last) give_back();
}

}  // namespace tenter::service
