// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/reply_cache.h"

namespace tenter::service {

ReplyCache::Look ReplyCache::look(const Key& key) {
  const auto [entry, fresh] = entries_.try_emplace(key);
  if (fresh) return {Known::fresh, nullptr};
  if (!entry->second) return {Known::working, nullptr};
  return {Known::answered, entry->second};
}

void ReplyCache::answer(const Key& key, std::shared_ptr<const ReplyText> reply,
                        Clock::time_point now) {
  bytes_ += reply->body.size() + reply->message.size();
  entries_[key] = std::move(reply);
  answered_.emplace_back(now, key);
  while (bytes_ > kMaxBytes && answered_.size() > 1) drop_oldest();
}

void ReplyCache::forget(const Key& key) {
  entries_.erase(key);
}

void ReplyCache::tidy(Clock::time_point now) {
  while (!answered_.empty() && now - answered_.front().first > std::chrono::seconds(60))
    drop_oldest();
}

void ReplyCache::drop_oldest() {
  const auto found = entries_.find(answered_.front().second);
  if (found != entries_.end() && found->second) {
    bytes_ -= found->second->body.size() + found->second->message.size();
    entries_.erase(found);
  }
  answered_.pop_front();
}

}  // namespace tenter::service
