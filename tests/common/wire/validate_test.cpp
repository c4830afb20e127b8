// SPDX-License-Identifier: Apache-2.0
// Every bound of every type, one at a time; then octets at random through the reader and the
// validator.
#include "common/wire/validate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/wire/types.h"
#include "tests/common/wire/samples.h"

namespace tenter::wire {
namespace {

namespace rtps = eprosima::fastrtps::rtps;
using samples::valid;

template <class T>
class EveryType : public ::testing::Test {};
using Types = ::testing::Types<v1::Server, v1::Presence, v1::Request, v1::Reply, v1::JobState,
                               v1::JobEvent, v1::FitProgress, v1::Chunk, v1::ChunkAck>;
TYPED_TEST_SUITE(EveryType, Types);

TYPED_TEST(EveryType, TheValidSampleIsAccepted) {
  EXPECT_EQ(check(valid<TypeParam>()), "");
}

TYPED_TEST(EveryType, AnEmptySampleIsRefused) {
  EXPECT_NE(check(TypeParam{}), "");
}

// Octets of a valid sample, some of them changed, cut or made longer. Whatever comes out of the
// reader must be either refused or be within the bounds that the rest of the program relies on.
TYPED_TEST(EveryType, MutatedOctetsNeverPassABound) {
  auto type = make_type(type_name<TypeParam>());
  TypeParam sample = valid<TypeParam>();
  rtps::SerializedPayload_t original(type->getSerializedSizeProvider(&sample)());
  ASSERT_TRUE(type->serialize(&sample, &original));
  std::mt19937 random(20261122);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int read = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<rtps::octet> octets(original.data, original.data + original.length);
    for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
      const std::size_t at = below(octets.size());
      switch (below(4)) {
        case 0:
          octets[at] = static_cast<rtps::octet>(random());
          break;
        case 1:
          octets[at] = static_cast<rtps::octet>(octets[at] ^ (1u << below(8)));
          break;
        case 2:
          octets.resize(1 + below(octets.size()));
          break;
        default:
          for (std::size_t k = at; k < std::min(at + 4, octets.size()); ++k) octets[k] = 0xff;
      }
    }
    rtps::SerializedPayload_t payload;
    payload.data = octets.data();
    payload.length = payload.max_size = static_cast<std::uint32_t>(octets.size());
    TypeParam got;
    const bool could_read = type->deserialize(&payload, &got);
    payload.data = nullptr;  // not its own
    if (!could_read) continue;
    ++read;
    const std::string why = check(got);
    EXPECT_LE(why.size(), 200u);
    if (!why.empty()) continue;
    EXPECT_EQ(check(got), "");  // and it is the same the second time
    rtps::InstanceHandle_t handle;
    EXPECT_EQ(type->getKey(&got, &handle, false), type->m_isGetKeyDefined);
  }
  EXPECT_GT(read, 100);  // not all of them fail at the first octet
}

template <class T, class Change>
void refused(Change change, const char* field) {
  T sample = valid<T>();
  change(sample);
  const std::string why = check(sample);
  EXPECT_NE(why.find(field), std::string::npos)
      << "expected a complaint about " << field << ", got '" << why << "'";
}

TEST(Validate, Requests) {
  refused<v1::Request>([](auto& s) { s.client_id({}); }, "client_id");
  refused<v1::Request>([](auto& s) { s.request_id({}); }, "request_id");
  refused<v1::Request>([](auto& s) { s.operation(""); }, "operation");
  refused<v1::Request>([](auto& s) { s.operation("Job"); }, "operation");
  refused<v1::Request>([](auto& s) { s.operation(std::string(65, 'a')); }, "operation");
  refused<v1::Request>([](auto& s) { s.operation(std::string("job\0list", 8)); }, "operation");
  refused<v1::Request>([](auto& s) { s.body().resize(v1::MAX_BODY + 1); }, "57344");
  auto largest = valid<v1::Request>();
  largest.body().resize(v1::MAX_BODY);
  EXPECT_EQ(check(largest), "");
}

TEST(Validate, Replies) {
  refused<v1::Reply>([](auto& s) { s.parts(0); }, "parts");
  refused<v1::Reply>([](auto& s) { s.parts(v1::MAX_REPLY_PARTS + 1); }, "parts");
  refused<v1::Reply>([](auto& s) { s.part(2); }, "part");
  refused<v1::Reply>([](auto& s) { s.status(1000); }, "status");
  refused<v1::Reply>([](auto& s) { s.message(std::string(v1::MAX_TEXT + 1, 'x')); }, "message");
  refused<v1::Reply>([](auto& s) { s.message("\xff"); }, "message");
  refused<v1::Reply>([](auto& s) { s.message("\x1b[31mred"); }, "message");
  refused<v1::Reply>([](auto& s) { s.body().resize(v1::MAX_BODY + 1); }, "body");
}

TEST(Validate, Jobs) {
  refused<v1::JobState>([](auto& s) { s.phase(static_cast<v1::JobPhase>(5)); }, "phase");
  refused<v1::JobState>([](auto& s) { s.phase(static_cast<v1::JobPhase>(0xffffffffu)); }, "phase");
  refused<v1::JobState>([](auto& s) { s.job_id(0); }, "job_id");
  refused<v1::JobState>([](auto& s) { s.user("a b"); }, "user");
  refused<v1::JobEvent>([](auto& s) { s.number(0); }, "number");
  refused<v1::JobEvent>([](auto& s) { s.kind(std::string(65, 'k')); }, "kind");
  refused<v1::JobEvent>([](auto& s) { s.phase(static_cast<v1::JobPhase>(77)); }, "phase");
  refused<v1::FitProgress>([](auto& s) { s.cost(std::nan("")); }, "cost");
  refused<v1::FitProgress>([](auto& s) { s.fraction(1.5); }, "fraction");
  refused<v1::FitProgress>([](auto& s) { s.fraction(std::nan("")); }, "fraction");
  refused<v1::FitProgress>([](auto& s) { s.iteration(-2); }, "iteration");
  refused<v1::FitProgress>([](auto& s) { s.elapsed_s(std::numeric_limits<double>::infinity()); },
                           "elapsed_s");
  refused<v1::FitProgress>([](auto& s) { s.detail(std::string(9000, 'd')); }, "detail");
}

TEST(Validate, Chunks) {
  refused<v1::Chunk>([](auto& s) { s.crc32c(s.crc32c() ^ 1); }, "crc32c");
  refused<v1::Chunk>([](auto& s) { s.data()[0] = 9; }, "crc32c");
  refused<v1::Chunk>([](auto& s) { s.index(3); }, "index");
  refused<v1::Chunk>([](auto& s) { s.index(0); }, "short");
  refused<v1::Chunk>([](auto& s) { s.count(0); }, "count");
  refused<v1::Chunk>([](auto& s) { s.count(v1::MAX_CHUNK_COUNT + 1); }, "count");
  refused<v1::Chunk>([](auto& s) { s.data().clear(); }, "data");
  refused<v1::Chunk>([](auto& s) { s.data().resize(v1::CHUNK_BYTES + 1); }, "data");
  refused<v1::ChunkAck>([](auto& s) { s.credit(v1::CHUNK_WINDOW + 1); }, "credit");
  refused<v1::ChunkAck>([](auto& s) { s.written(v1::MAX_CHUNK_COUNT + 1); }, "written");
}

TEST(Validate, Peers) {
  refused<v1::Server>([](auto& s) { s.server_id({}); }, "server_id");
  refused<v1::Server>([](auto& s) { s.chunk_bytes(1); }, "chunk_bytes");
  refused<v1::Server>([](auto& s) { s.body_max(1u << 31); }, "body_max");
  refused<v1::Server>([](auto& s) { s.chunk_window(0); }, "chunk_window");
  refused<v1::Presence>([](auto& s) { s.user(std::string(33, 'u')); }, "user");
  refused<v1::Presence>([](auto& s) { s.name("a\rb"); }, "name");
}

TEST(CleanText, KeepsWholeCharactersAndReplacesTheRest) {
  EXPECT_EQ(clean_text("plain", 100), "plain");
  EXPECT_EQ(clean_text("a\xff\x01z", 100), "a??z");
  EXPECT_EQ(clean_text("\xc3\xa4\xc3\xa4", 3), "\xc3\xa4");
  EXPECT_EQ(clean_text("\xed\xa0\x80", 100), "???");  // a surrogate
  EXPECT_EQ(clean_text("\xc0\xaf", 100), "??");       // an overlong slash
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    std::string text(random() % 60, '\0');
    for (char& c : text) c = static_cast<char>(random());
    const std::string clean = clean_text(text, 40);
    EXPECT_LE(clean.size(), 40u);
    EXPECT_TRUE(is_clean_text(clean));
  }
}

}  // namespace
}  // namespace tenter::wire
