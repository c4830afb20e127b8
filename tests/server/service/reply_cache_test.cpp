// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/reply_cache.h"

#include <gtest/gtest.h>

namespace tenter::service {
namespace {

using Known = ReplyCache::Known;

ReplyCache::Key key(std::uint8_t number) {
  ReplyCache::Key key{};
  key.first[0] = 1;
  key.second[0] = number;
  return key;
}

std::shared_ptr<const ReplyText> text(std::string body) {
  return std::make_shared<const ReplyText>(
      ReplyText{true, ErrorKind::internal, {}, std::move(body)});
}

TEST(ReplyCache, FreshThenWorkingThenAnswered) {
  ReplyCache cache;
  const auto now = ReplyCache::Clock::now();
  EXPECT_EQ(cache.look(key(1)).known, Known::fresh);
  EXPECT_EQ(cache.look(key(1)).known, Known::working);
  EXPECT_EQ(cache.look(key(2)).known, Known::fresh);
  cache.answer(key(1), text("one"), now);
  const auto look = cache.look(key(1));
  EXPECT_EQ(look.known, Known::answered);
  EXPECT_EQ(look.reply->body, "one");
  cache.forget(key(2));
  EXPECT_EQ(cache.look(key(2)).known, Known::fresh);
}

TEST(ReplyCache, ForgetsWhatIsOldAndWhatIsTooMuch) {
  ReplyCache cache;
  const auto start = ReplyCache::Clock::now();
  cache.look(key(1));
  cache.answer(key(1), text("old"), start);
  cache.tidy(start + std::chrono::seconds(59));
  EXPECT_EQ(cache.look(key(1)).known, Known::answered);
  cache.tidy(start + std::chrono::seconds(61));
  EXPECT_EQ(cache.look(key(1)).known, Known::fresh);

  for (std::uint8_t i = 10; i < 20; ++i) {
    cache.look(key(i));
    cache.answer(key(i), text(std::string(1u << 20, 'x')), start);
  }
  EXPECT_EQ(cache.look(key(10)).known, Known::fresh);
  EXPECT_EQ(cache.look(key(19)).known, Known::answered);
}

}  // namespace
}  // namespace tenter::service
