// SPDX-License-Identifier: Apache-2.0
// Identifiers, users and topics.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "common/wire/participant.h"
#include "common/wire/topics.h"
#include "common/wire/uuid.h"
#include "tenter_v1.h"

namespace tenter::wire {
namespace {

TEST(Uuid, TextAndBack) {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) {
    const Uuid id = random_uuid();
    const std::string text = to_text(id);
    EXPECT_EQ(text.size(), 32u);
    EXPECT_EQ(parse_uuid(text), id);
    EXPECT_EQ(uuid_of(text), id);
    EXPECT_TRUE(seen.insert(text).second);
  }
  EXPECT_EQ(parse_uuid("00112233-4455-6677-8899-AABBCCDDEEFF"),
            parse_uuid("00112233445566778899aabbccddeeff"));
  for (const char* bad : {"", "00", "zz112233445566778899aabbccddeeff",
                          "00112233445566778899aabbccddeeff0", "../../../../etc/passwd"})
    EXPECT_FALSE(parse_uuid(bad)) << bad;
  EXPECT_EQ(uuid_of("some name"), uuid_of("some name"));
  EXPECT_NE(uuid_of("some name"), uuid_of("some other name"));
}

TEST(Topics, NamesCarryVersionAndUser) {
  EXPECT_EQ(request_topic("ada").name, "tenter/v1/request/ada");
  EXPECT_EQ(user_of_request_topic("tenter/v1/request/ada"), "ada");
  for (const char* other : {"tenter/v2/request/ada", "tenter/v1/reply/ada", "tenter/v1/request/",
                            "tenter/v1/request/a b", "tenter/v1/request/../x", "request/ada", ""})
    EXPECT_EQ(user_of_request_topic(other), "") << other;
}

TEST(Topics, Users) {
  for (const char* good : {"a", "Ada_L", "ada.lovelace-2", "_x", "0"})
    EXPECT_TRUE(is_user_name(good));
  EXPECT_TRUE(is_user_name(std::string(v1::MAX_USER, 'x')));
  EXPECT_FALSE(is_user_name(std::string(v1::MAX_USER + 1, 'x')));
  for (const char* bad : {"", ".a", "-a", "a/b", "a b", "a\n", "\xc3\xa4"})
    EXPECT_FALSE(is_user_name(bad));
}

TEST(Topics, EveryHistoryIsBounded) {
  for (const Topic& topic :
       {server_topic(), presence_topic(), request_topic("a"), reply_topic("a"), job_state_topic(),
        job_event_topic(), fit_progress_topic(), chunk_up_topic("a", random_uuid()),
        chunk_down_topic("a", random_uuid()), chunk_ack_topic("a", random_uuid())}) {
    EXPECT_GT(topic.depth, 0) << topic.name;
    EXPECT_GT(topic.max_instances, 0) << topic.name;
    EXPECT_TRUE(topic.reliable) << topic.name;
    EXPECT_TRUE(!topic.keep_all || topic.max_instances == 1) << topic.name;
  }
}

TEST(Domain, OptionThenEnvironmentThenDefault) {
  ::unsetenv("TENTER_DOMAIN");
  EXPECT_EQ(domain_or_default({}).value(), kDefaultDomain);
  ::setenv("TENTER_DOMAIN", "7", 1);
  EXPECT_EQ(domain_or_default({}).value(), 7);
  EXPECT_EQ(domain_or_default(9).value(), 9);
  for (const char* bad : {"x", "7x", "-1", "233", " 7"}) {
    ::setenv("TENTER_DOMAIN", bad, 1);
    EXPECT_FALSE(domain_or_default({})) << bad;
  }
  ::unsetenv("TENTER_DOMAIN");
  EXPECT_FALSE(domain_or_default(233));
}

TEST(Participant, RefusesOpenNetworksWithoutSecurity) {
  ParticipantOptions options;
  options.domain = 231;
  options.interfaces = {"10.0.0.1"};
  const auto open = Participant::create(options);
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("DDS Security"), std::string::npos);
  options.security = "/nonexistent";
  const auto no_files = Participant::create(options);
  ASSERT_FALSE(no_files);
  EXPECT_NE(no_files.error().message.find("identity_ca.pem"), std::string::npos);
  options = {};
  options.interfaces = {"localhost"};
  EXPECT_FALSE(Participant::create(options));
}

}  // namespace
}  // namespace tenter::wire
