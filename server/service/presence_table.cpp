// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/presence_table.h"

#include <algorithm>

#include "common/wire/validate.h"

namespace tenter::service {

namespace v1 = wire::v1;

namespace {

constexpr auto kSilent = std::chrono::seconds(6);

}  // namespace

PresenceTable::PresenceTable(const Context& context) {
  wire::ReaderHandlers<v1::Presence> handlers;
  handlers.on_sample = [this](v1::Presence& sample, const wire::Peer& peer) {
    std::lock_guard lock(mutex_);
    const auto [entry, fresh] = entries_.try_emplace(sample.client_id());
    entry->second.last_seen = Clock::now();
    if (fresh) entry->second.since = entry->second.last_seen;
    entry->second.peer = peer;
    entry->second.client = {sample.user(), sample.name(), sample.process(), 0};
  };
  handlers.on_match = [this](const wire::Peer& peer, bool came) {
    if (!came) leave(peer);
  };
  reader_ = std::make_unique<wire::Reader<v1::Presence>>(context.participant,
                                                         wire::presence_topic(), handlers);
}

PresenceTable::~PresenceTable() = default;

void PresenceTable::leave(const wire::Peer& peer) {
  std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return entry.second.peer == peer; });
}

void PresenceTable::tidy() {
  const auto silent_since = Clock::now() - kSilent;
  std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return entry.second.last_seen < silent_since; });
}

std::vector<PresentClient> PresenceTable::clients(const Caller& asking) const {
  const auto now = Clock::now();
  std::vector<PresentClient> clients;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, entry] : entries_) {
      clients.push_back(entry.client);
      clients.back().connected_s = std::chrono::duration<double>(now - entry.since).count();
    }
    if (!entries_.contains(asking.client)) clients.push_back({asking.user, "", 0, 0});
  }
  std::sort(clients.begin(), clients.end(), [](const PresentClient& a, const PresentClient& b) {
    return a.connected_s > b.connected_s;
  });
  return clients;
}

}  // namespace tenter::service
