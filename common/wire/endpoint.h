// SPDX-License-Identifier: Apache-2.0
// Typed readers and writers of one topic, without a DDS header.
//
//   Reader<v1::Chunk> reader(participant, chunk_up_topic("ada"), {.on_sample = [](v1::Chunk& c,
//   const Peer&) {...}}); Writer<v1::Chunk> writer(participant, chunk_up_topic("ada")); if (auto
//   sent = writer.write(chunk, std::chrono::seconds(5)); !sent) ...
//
// All handlers run in the participant's loop. A sample reaches on_sample only after its validator
// accepted it; what was refused is counted and, if there is a handler, handed to on_refused. A
// handler must not destroy its own reader: post that. Endpoints may be made and destroyed in any
// thread, and are gone, with no handler running, when the destructor returns.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/base/error.h"
#include "common/wire/participant.h"
#include "common/wire/topics.h"
#include "common/wire/uuid.h"

// the generated types; tenter_v1.h where they are used
namespace tenter::wire::v1 {
class Server;
class Presence;
class Request;
class Reply;
class JobState;
class JobEvent;
class FitProgress;
class Chunk;
class ChunkAck;
}  // namespace tenter::wire::v1

namespace tenter::wire {

/// Runs when a remote endpoint on the same topic came (true) or went.
using MatchHandler = std::function<void(const Peer&, bool)>;

struct ReaderCounts {
  std::uint64_t taken = 0;
  std::uint64_t refused = 0;  ///< by the validator, or not readable at all
};

class WriterCore {
 public:
  WriterCore(Participant& participant, const Topic& topic, const char* type, MatchHandler on_match);
  ~WriterCore();
  WriterCore(const WriterCore&) = delete;
  WriterCore& operator=(const WriterCore&) = delete;

  Expected<void> write(void* sample, std::chrono::milliseconds deadline);
  bool matched(const Peer& peer) const;
  int matched_count() const;
  bool wait_acknowledged(std::chrono::milliseconds deadline);

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

class ReaderCore {
 public:
  struct Handlers {
    std::function<std::string(const void*)> check;  ///< "" or why not
    std::function<void(void*, const Peer&)> sample;
    std::function<void(void*, const Peer&, const std::string&)> refused;
    MatchHandler match;
    MatchHandler alive;
  };
  ReaderCore(Participant& participant, const Topic& topic, const char* type, Handlers handlers);
  ~ReaderCore();
  ReaderCore(const ReaderCore&) = delete;
  ReaderCore& operator=(const ReaderCore&) = delete;

  bool matched(const Peer& peer) const;
  ReaderCounts counts() const;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

/// "tenter::wire::v1::Chunk": names a type of the wire for the files that see DDS.
template <class T>
const char* type_name();
/// "" if a received sample is within all bounds, else one sentence; see validate.h.
template <class T>
std::string check(const T& sample);

template <class T>
class Writer {
 public:
  /// `epoch` goes into every header.
  Writer(Participant& participant, const Topic& topic, MatchHandler on_match = {},
         std::uint64_t epoch = 0)
      : core_(participant, topic, type_name<T>(), std::move(on_match)), epoch_(epoch) {}

  /// Fills the header and sends; tries again until the deadline when a full history refuses.
  Expected<void> write(T& sample,
                       std::chrono::milliseconds deadline = std::chrono::milliseconds(0)) {
    sample.header().epoch(epoch_);
    sample.header().counter(++counter_);
    return core_.write(&sample, deadline);
  }
  bool matched(const Peer& peer) const { return core_.matched(peer); }
  int matched_count() const { return core_.matched_count(); }
  bool wait_acknowledged(std::chrono::milliseconds deadline) {
    return core_.wait_acknowledged(deadline);
  }
  void set_epoch(std::uint64_t epoch) { epoch_ = epoch; }

 private:
  WriterCore core_;
  std::atomic<std::uint64_t> epoch_;
  std::atomic<std::uint64_t> counter_{0};
};

template <class T>
struct ReaderHandlers {
  std::function<void(T&, const Peer&)> on_sample;  ///< may move out of the sample
  std::function<void(T&, const Peer&, const std::string&)> on_refused;  ///< the sample and why
  MatchHandler on_match;
  MatchHandler on_alive;  ///< the peer's liveliness on this topic came back (true) or was lost
};

template <class T>
class Reader {
 public:
  Reader(Participant& participant, const Topic& topic, ReaderHandlers<T> handlers)
      : core_(participant, topic, type_name<T>(), erase(std::move(handlers))) {}

  bool matched(const Peer& peer) const { return core_.matched(peer); }
  ReaderCounts counts() const { return core_.counts(); }

 private:
  static ReaderCore::Handlers erase(ReaderHandlers<T> typed) {
    ReaderCore::Handlers handlers;
    handlers.check = [](const void* sample) { return check(*static_cast<const T*>(sample)); };
    handlers.sample = [f = std::move(typed.on_sample)](void* sample, const Peer& peer) {
      if (f) f(*static_cast<T*>(sample), peer);
    };
    if (typed.on_refused)
      handlers.refused = [f = std::move(typed.on_refused)](void* sample, const Peer& peer,
                                                           const std::string& why) {
        f(*static_cast<T*>(sample), peer, why);
      };
    handlers.match = std::move(typed.on_match);
    handlers.alive = std::move(typed.on_alive);
    return handlers;
  }

  ReaderCore core_;
};

}  // namespace tenter::wire
