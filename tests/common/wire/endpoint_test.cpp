// SPDX-License-Identifier: Apache-2.0
// Readers and writers over loopback: what arrives, what is refused, what a silent or stopped reader
// costs others.
#include "common/wire/endpoint.h"

#include <gtest/gtest.h>

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <mutex>
#include <random>
#include <thread>

#include "common/wire/participant_impl.h"
#include "common/wire/qos.h"
#include "tests/common/wire/domain.h"
#include "tests/common/wire/samples.h"

namespace tenter::wire {
namespace {

using samples::valid;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

std::unique_ptr<Participant> join(int lost_percent = 0) {
  static const int domain =
      10 + static_cast<int>(::getpid() % 40);  // below those of the daemons' tests
  ParticipantOptions options;
  options.domain = domain;
  options.lost_percent = lost_percent;
  return std::move(Participant::create(options).value());
}

template <class Condition>
bool eventually(Condition condition, Clock::duration patience = seconds(10)) {
  const auto end = Clock::now() + patience;
  while (Clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return condition();
}

TEST(Endpoint, SamplesArriveInOrderAndBothSidesKnowOfEachOther) {
  auto here = join(), there = join();
  std::vector<std::uint64_t> got;
  std::atomic<int> count{0}, matches{0};
  ReaderHandlers<v1::Request> handlers;
  handlers.on_sample = [&](v1::Request& request, const Peer&) {
    got.push_back(request.header().counter());
    ++count;
  };
  handlers.on_match = [&](const Peer&, bool came) { matches += came ? 1 : -1; };
  auto reader = std::make_unique<Reader<v1::Request>>(*there, request_topic("a"), handlers);
  Writer<v1::Request> writer(*here, request_topic("a"), {}, 5);
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 1 && matches == 1; }));
  for (int i = 0; i < 60; ++i) {
    auto sample = valid<v1::Request>();
    ASSERT_TRUE(writer.write(sample));
    EXPECT_EQ(sample.header().epoch(), 5u);
  }
  ASSERT_TRUE(eventually([&] { return count == 60; }));
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_EQ(got[i], i + 1);
  reader.reset();
  EXPECT_TRUE(eventually([&] { return writer.matched_count() == 0; }));
}

TEST(Endpoint, WhatTheValidatorRefusesDoesNotArrive) {
  auto here = join(), there = join();
  std::atomic<int> good{0}, bad{0};
  std::string why;
  ReaderHandlers<v1::Request> handlers;
  handlers.on_sample = [&](v1::Request&, const Peer&) { ++good; };
  handlers.on_refused = [&](v1::Request&, const Peer&, const std::string& reason) {
    why = reason;
    ++bad;
  };
  Reader<v1::Request> reader(*there, request_topic("a"), handlers);
  Writer<v1::Request> writer(*here, request_topic("a"));
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 1; }));
  auto large = valid<v1::Request>();
  large.body().resize(500000);
  ASSERT_TRUE(writer.write(large));
  auto fine = valid<v1::Request>();
  ASSERT_TRUE(writer.write(fine));
  ASSERT_TRUE(eventually([&] { return good == 1 && bad == 1; }));
  EXPECT_NE(why.find("500000"), std::string::npos);
  EXPECT_EQ(reader.counts().taken, 2u);
  EXPECT_EQ(reader.counts().refused, 1u);
}

// Writes octets of its own under the name of a type of the wire.
class Nonsense final : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit Nonsense(const char* name) {
    m_typeSize = 256;
    m_isGetKeyDefined = false;
    setName(name);
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& octets = *static_cast<std::vector<std::uint8_t>*>(data);
    std::copy(octets.begin(), octets.end(), payload->data);
    payload->length = static_cast<std::uint32_t>(octets.size());
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      return static_cast<std::uint32_t>(static_cast<std::vector<std::uint8_t>*>(data)->size());
    };
  }
  void* createData() override { return new std::vector<std::uint8_t>; }
  void deleteData(void* data) override { delete static_cast<std::vector<std::uint8_t>*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool) override {
    for (unsigned i = 0; i < 16; ++i) handle->value[i] = 3;
    return true;
  }
};

// No crash, nothing handed over, and what comes after them is read.
TEST(Endpoint, OctetsThatAreNoSampleAreDropped) {
  namespace dds = eprosima::fastdds::dds;
  auto here = join(), there = join(), odd = join();
  std::atomic<int> good{0};
  ReaderHandlers<v1::Reply> handlers;
  handlers.on_sample = [&](v1::Reply&, const Peer&) { ++good; };
  Reader<v1::Reply> reader(*there, reply_topic("a"), handlers);
  Writer<v1::Reply> writer(*here, reply_topic("a"));
  auto& inner = odd->impl();
  dds::Topic* topic = inner.take_topic(reply_topic("a").name,
                                       dds::TypeSupport(new Nonsense(type_name<v1::Reply>())));
  ASSERT_NE(topic, nullptr);
  dds::DataWriter* raw = inner.publisher_->create_datawriter(topic, writer_qos(reply_topic("a")));
  ASSERT_NE(raw, nullptr);
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 1; }));
  dds::PublicationMatchedStatus status;
  ASSERT_TRUE(eventually([&] {
    raw->get_publication_matched_status(status);
    return status.current_count == 1;
  }));
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> octets(random() % 200);
    for (std::uint8_t& octet : octets) octet = static_cast<std::uint8_t>(i % 2 ? 0xff : random());
    raw->write(&octets, dds::HANDLE_NIL);
  }
  auto fine = valid<v1::Reply>();
  ASSERT_TRUE(writer.write(fine));
  EXPECT_TRUE(eventually([&] { return good == 1; }));
  inner.publisher_->delete_datawriter(raw);
  inner.release_topic(topic);
}

TEST(Endpoint, LateReadersGetTheLatestValueOfATransientTopic) {
  auto here = join(), there = join();
  Writer<v1::JobState> writer(*here, job_state_topic());
  for (int job = 1; job <= 300; ++job)  // many more instances than the default of ten
    for (int revision = 1; revision <= 2; ++revision) {
      auto sample = valid<v1::JobState>();
      sample.job_id(job);
      sample.revision(static_cast<std::uint64_t>(revision));
      ASSERT_TRUE(writer.write(sample)) << job;
    }
  std::atomic<int> got{0}, stale{0};
  ReaderHandlers<v1::JobState> handlers;
  handlers.on_sample = [&](v1::JobState& state, const Peer&) {
    ++got;
    stale += state.revision() != 2;
  };
  Reader<v1::JobState> reader(*there, job_state_topic(), handlers);
  EXPECT_TRUE(eventually([&] { return got >= 300; }));
  EXPECT_EQ(got, 300);
  EXPECT_EQ(stale, 0);
}

// A reader whose loop is stuck, like a stopped process: the last 64 are kept for it, nobody waits.
TEST(Endpoint, AReaderThatDoesNotReadDoesNotHoldUpRepliesToOthers) {
  auto here = join(), stuck = join(), lively = join();
  std::mutex gate;
  std::atomic<int> got{0}, late{0};
  ReaderHandlers<v1::Reply> blocked, counting;
  blocked.on_sample = [&](v1::Reply&, const Peer&) {
    std::lock_guard wait(gate);
    ++late;
  };
  counting.on_sample = [&](v1::Reply&, const Peer&) { ++got; };
  Reader<v1::Reply> first(*stuck, reply_topic("a"), blocked);
  Reader<v1::Reply> second(*lively, reply_topic("a"), counting);
  Writer<v1::Reply> writer(*here, reply_topic("a"));
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 2; }));
  gate.lock();
  const auto start = Clock::now();
  for (int i = 0; i < 500; ++i) {
    auto sample = valid<v1::Reply>();
    sample.body().resize(20000);
    ASSERT_TRUE(writer.write(sample));
    if (i % 16 == 15) {
      ASSERT_TRUE(eventually([&] { return got > i - 16; }));
    }
  }
  EXPECT_TRUE(eventually([&] { return got == 500; }));
  EXPECT_LT(Clock::now() - start, seconds(5));
  gate.unlock();
  EXPECT_TRUE(eventually([&] { return late > 0; }));
}

TEST(Endpoint, ChunksAllArriveAlsoWithLoss) {
  auto here = join(10), there = join(10);
  const Uuid transfer = random_uuid();
  std::atomic<std::uint32_t> got{0};
  std::atomic<int> wrong{0};
  ReaderHandlers<v1::Chunk> handlers;
  handlers.on_sample = [&](v1::Chunk& chunk, const Peer&) { wrong += chunk.index() != got++; };
  Reader<v1::Chunk> reader(*there, chunk_up_topic("a", transfer), handlers);
  Writer<v1::Chunk> writer(*here, chunk_up_topic("a", transfer));
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 1; }));
  v1::Chunk chunk;
  chunk.transfer_id(transfer);
  chunk.count(40);
  chunk.data().assign(v1::CHUNK_BYTES, 7);
  chunk.crc32c(crc32c(chunk.data().data(), chunk.data().size()));
  for (std::uint32_t i = 0; i < 40; ++i) {
    chunk.index(i);
    ASSERT_TRUE(writer.write(chunk, seconds(20))) << i;
  }
  EXPECT_TRUE(eventually([&] { return got == 40; }, seconds(20)));
  EXPECT_EQ(wrong, 0);
}

TEST(Endpoint, AFullHistoryIsSaidAfterTheDeadline) {
  auto here = join(), there = join();
  const Uuid transfer = random_uuid();
  std::mutex gate;
  ReaderHandlers<v1::Chunk> handlers;
  handlers.on_sample = [&](v1::Chunk&, const Peer&) { std::lock_guard wait(gate); };
  Reader<v1::Chunk> reader(*there, chunk_up_topic("a", transfer), handlers);
  Writer<v1::Chunk> writer(*here, chunk_up_topic("a", transfer));
  ASSERT_TRUE(eventually([&] { return writer.matched_count() == 1; }));
  v1::Chunk chunk = valid<v1::Chunk>();
  chunk.transfer_id(transfer);
  gate.lock();
  Expected<void> sent;
  const auto start = Clock::now();
  for (int i = 0; i < 200 && sent; ++i) sent = writer.write(chunk, milliseconds(300));
  EXPECT_FALSE(sent);
  EXPECT_GE(Clock::now() - start, milliseconds(250));
  gate.unlock();
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ErrorKind::unavailable);
}

TEST(Endpoint, AWriterThatGoesIsNoticed) {
  auto here = join(), there = join();
  std::atomic<int> matched{0};
  ReaderHandlers<v1::Presence> handlers;
  handlers.on_match = [&](const Peer&, bool came) { matched += came ? 1 : -1; };
  Reader<v1::Presence> reader(*there, presence_topic(), handlers);
  auto writer = std::make_unique<Writer<v1::Presence>>(*here, presence_topic());
  ASSERT_TRUE(eventually([&] { return writer->matched_count() == 1 && matched == 1; }));
  writer.reset();
  EXPECT_TRUE(eventually([&] { return matched == 0; }));
}

TEST(Endpoint, TheMajorVersionIsInEveryName) {
  EXPECT_NE(std::string(type_name<v1::Reply>()).find("::v1::"), std::string::npos);
  for (const Topic& topic : {server_topic(), job_state_topic(), request_topic("a")})
    EXPECT_EQ(topic.name.rfind("tenter/v1/", 0), 0u);
}

// What a program of the next major version would write is not seen, rather than misread.
TEST(Endpoint, AnotherMajorVersionDoesNotMatch) {
  auto here = join(), there = join();
  Topic next = job_state_topic();
  next.name = "tenter/v2/job_state";
  Reader<v1::JobState> old(*there, job_state_topic(), {});
  Writer<v1::JobState> writer(*here, next);
  auto sample = valid<v1::JobState>();
  ASSERT_TRUE(writer.write(sample));
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_EQ(writer.matched_count(), 0);
  EXPECT_EQ(old.counts().taken, 0u);
}

}  // namespace
}  // namespace tenter::wire
