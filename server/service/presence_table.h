// SPDX-License-Identifier: GPL-3.0-or-later
// Who is connected: clients say so every two seconds, and are forgotten when they leave or fall
// silent for six. (The liveliness of this version of Fast DDS notices when a topic's only writer
// falls silent, not one of several.)
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/wire/endpoint.h"
#include "server/service/context.h"
#include "server/service/operations.h"

namespace tenter::service {

struct PresentClient {
  std::string user;
  std::string name;
  std::uint32_t process = 0;
  double connected_s = 0;
};

class PresenceTable {
 public:
  explicit PresenceTable(const Context& context);
  ~PresenceTable();

  /// Any thread; the longest connected first. `asking` is among them, also where its request was
  /// faster than its first word on this topic; then without a name.
  std::vector<PresentClient> clients(const Caller& asking) const;
  /// Loop thread, now and then.
  void tidy();

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    PresentClient client;
    wire::Peer peer;
    Clock::time_point since;
    Clock::time_point last_seen;
  };
  void leave(const wire::Peer& peer);

  mutable std::mutex mutex_;
  std::map<wire::Uuid, Entry> entries_;
  std::unique_ptr<wire::Reader<wire::v1::Presence>> reader_;
};

}  // namespace tenter::service
