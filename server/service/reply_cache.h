// SPDX-License-Identifier: GPL-3.0-or-later
// Which requests are being worked on, and what was answered lately: so that a request that comes
// again because its reply was lost is answered from memory. What changes something is protected for
// longer, by the database.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <utility>

#include "common/wire/uuid.h"
#include "server/service/reply.h"

namespace tenter::service {

/// Not locked: used by the loop's thread only.
class ReplyCache {
 public:
  using Clock = std::chrono::steady_clock;
  using Key = std::pair<wire::Uuid, wire::Uuid>;  ///< client, request

  enum class Known { fresh, working, answered };
  struct Look {
    Known known = Known::fresh;
    std::shared_ptr<const ReplyText> reply;  ///< when answered
  };
  /// Notes a fresh request as being worked on.
  Look look(const Key& key);
  void answer(const Key& key, std::shared_ptr<const ReplyText> reply, Clock::time_point now);
  /// The request was not taken after all.
  void forget(const Key& key);
  /// Drops what was answered longer ago than 60 s.
  void tidy(Clock::time_point now);

 private:
  static constexpr std::size_t kMaxBytes = 4u << 20;
  void drop_oldest();

  std::map<Key, std::shared_ptr<const ReplyText>> entries_;  ///< null: being worked on
  std::deque<std::pair<Clock::time_point, Key>> answered_;   ///< oldest first
  std::size_t bytes_ = 0;
};

}  // namespace tenter::service
