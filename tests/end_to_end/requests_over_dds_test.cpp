// SPDX-License-Identifier: GPL-3.0-or-later
// Requests that are malformed, too large, unknown, repeated or late, against a real daemon; and no
// daemon at all.
#include <gtest/gtest.h>
#include <signal.h>

#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/wire/validate.h"
#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"

namespace tenter::test {
namespace {

namespace v1 = wire::v1;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// A client that sends whatever it is given.
class RawClient {
 public:
  RawClient(int domain, const std::string& user) {
    wire::ParticipantOptions place;
    place.domain = domain;
    place.name = "raw";
    auto participant = wire::Participant::create(place);
    if (!participant) throw std::runtime_error(participant.error().message);
    participant_ = std::move(*participant);
    wire::ReaderHandlers<v1::Reply> on_reply;
    on_reply.on_sample = [this](v1::Reply& reply, const wire::Peer&) {
      std::lock_guard lock(mutex_);
      if (reply.client_id() == id_) got_.push_back(reply);
      changed_.notify_all();
    };
    replies_ =
        std::make_unique<wire::Reader<v1::Reply>>(*participant_, wire::reply_topic(user), on_reply);
    wire::ReaderHandlers<v1::Server> on_server;
    on_server.on_sample = [this](v1::Server& server, const wire::Peer& peer) {
      std::lock_guard lock(mutex_);
      if (server.name() != std::getenv("TENTER_SERVER")) return;
      server_ = server.server_id();
      peer_ = peer;
      changed_.notify_all();
    };
    servers_ =
        std::make_unique<wire::Reader<v1::Server>>(*participant_, wire::server_topic(), on_server);
    requests_ =
        std::make_unique<wire::Writer<v1::Request>>(*participant_, wire::request_topic(user));
    std::unique_lock lock(mutex_);
    const auto end = Clock::now() + std::chrono::seconds(20);
    while (!(server_ != wire::Uuid{} && requests_->matched(peer_) && replies_->matched(peer_))) {
      if (Clock::now() > end) throw std::runtime_error("no server was found");
      changed_.wait_for(lock, std::chrono::milliseconds(5));
    }
  }

  v1::Request make(const std::string& operation, const std::string& body) {
    v1::Request request;
    request.client_id(id_);
    request.server_id(server_);
    request.request_id(wire::random_uuid());
    request.operation(operation);
    request.body().assign(body.begin(), body.end());
    return request;
  }

  void send(v1::Request& request) { ASSERT_TRUE(requests_->write(request)); }

  /// Waits until so many replies came.
  std::vector<v1::Reply> replies(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(5), [&] { return got_.size() >= count; });
    return got_;
  }

 private:
  const wire::Uuid id_ = wire::random_uuid();
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<v1::Reply> got_;
  wire::Uuid server_{};
  wire::Peer peer_{};
  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<wire::Reader<v1::Reply>> replies_;
  std::unique_ptr<wire::Reader<v1::Server>> servers_;
  std::unique_ptr<wire::Writer<v1::Request>> requests_;
};

TEST(RequestsOverDds, Status) {
  DaemonOptions named;
  named.name = "lab";
  Daemon daemon(named);
  auto client = daemon.connect();
  ASSERT_TRUE(client) << client.error().message;
  const json status = json::parse(client->server_status().value());
  ASSERT_EQ(status["clients"].size(), 1u);
  EXPECT_EQ(status["server"]["name"], "lab");
  EXPECT_EQ(status["server"]["wire_major"], 1);
  EXPECT_EQ(status["server"]["domain"], daemon.domain());
  EXPECT_EQ(status["workers"]["slots"], 2);
  EXPECT_EQ(status["clients"][0]["user"], "ada");
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(RequestsOverDds, BadOnesGetAReplyThatSaysSo) {
  Daemon daemon;
  auto client = daemon.connect().value();
  const auto message = [&](const std::string& operation, const std::string& body) {
    auto reply = client.request(operation, body);
    EXPECT_FALSE(reply);
    return reply ? Error{} : reply.error();
  };
  EXPECT_EQ(message("job.fly", "{}").kind, ErrorKind::not_found);
  EXPECT_NE(message("job.fly", "{}").message.find("job.fly"), std::string::npos);
  EXPECT_EQ(message("job.show", "[1]").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.show", "{\"job\"").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.show", std::string("{\"job\":\"\xff\"}")).kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.show", std::string(30000, '[')).kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.show", "{\"job\": 1e300}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.list", "{\"limit\": 1000000}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.list", "{\"state\": \"lost\"}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("job.submit", "{\"spec\": 3}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("capture.open", "{\"sha256\": \"x\", \"size\": 3}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("capture.open", "{\"size\": -3}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("capture.commit", "{\"transfer\": \"../../etc\"}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("capture.store", "{}").kind, ErrorKind::bad_input);
  EXPECT_EQ(message("capture.store", "{\"transfer\": \"" + std::string(32, '0') +
                                         "\", \"chunks_sha256\": \"" + std::string(64, '0') + "\"}")
                .kind,
            ErrorKind::not_found);
  EXPECT_EQ(message("file.more",
                    "{\"transfer\": \"" + std::string(32, 'a') + "\", \"from\": 0, \"count\": 1}")
                .kind,
            ErrorKind::not_found);
  const Error large = message("job.submit", "{\"x\": \"" + std::string(70000, 'x') + "\"}");
  EXPECT_EQ(large.kind, ErrorKind::bad_input);
  EXPECT_NE(large.message.find("57344"), std::string::npos) << large.message;
  EXPECT_TRUE(client.server_status());
}

TEST(RequestsOverDds, AnOversizedSampleGetsAReplyToo) {
  Daemon daemon;
  RawClient raw(daemon.domain(), "ada");
  auto large = raw.make("server.status", std::string(500000, ' '));
  raw.send(large);
  auto odd = raw.make("Server; status", "{}");
  raw.send(odd);
  const auto replies = raw.replies(2);
  ASSERT_EQ(replies.size(), 2u);
  for (const v1::Reply& reply : replies)
    EXPECT_EQ(reply.status(), static_cast<std::uint32_t>(ErrorKind::bad_input));
  EXPECT_NE(replies[0].message().find("500000"), std::string::npos) << replies[0].message();
}

TEST(RequestsOverDds, ARepeatIsAnsweredFromMemory) {
  Daemon daemon;
  RawClient raw(daemon.domain(), "ada");
  const auto file = daemon.folder() / "c.h5";
  write_noise_capture(file, 100, 1);
  auto client = daemon.connect().value();
  const auto capture = client.upload_capture(file).value().sha256;
  auto submit =
      raw.make("job.submit", "{\"spec\": " + fake_job(capture, "{\"sleep_ms\": 30000}") + "}");
  std::vector<v1::Reply> answers;
  for (std::size_t seen = 0; answers.size() < 3;) {
    raw.send(submit);
    const auto replies = raw.replies(seen + 1);
    ASSERT_GT(replies.size(), seen);
    for (; seen < replies.size(); ++seen)
      if (replies[seen].status() != v1::STATUS_WORKING) answers.push_back(replies[seen]);
  }
  EXPECT_EQ(answers[0].body(), answers[2].body());
  EXPECT_EQ(answers[0].status(), 0u) << answers[0].message();
  EXPECT_EQ(json::parse(client.list_jobs().value())["total"], 1);
}

TEST(RequestsOverDds, ALateServerGetsOneRequestNotThree) {
  Daemon daemon;
  const auto file = daemon.folder() / "c.h5";
  write_noise_capture(file, 100, 1);
  auto client = daemon.connect().value();
  const auto capture = client.upload_capture(file).value().sha256;
  daemon.send_signal(SIGSTOP);
  std::thread waker([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(3500));
    daemon.send_signal(SIGCONT);
  });
  client::SubmitRequest request;
  request.spec_json = fake_job(capture, "{\"sleep_ms\": 30000}");
  auto submitted = client.submit(request);
  waker.join();
  ASSERT_TRUE(submitted) << submitted.error().message;
  EXPECT_EQ(json::parse(client.list_jobs().value())["total"], 1);
}

TEST(RequestsOverDds, ARequestOutlivesARestart) {
  Daemon daemon;
  auto client = daemon.connect().value();
  const auto before = json::parse(client.server_status().value())["server"]["epoch"];
  daemon.kill();
  std::thread starter([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    daemon.start();
  });
  auto status = client.server_status();
  starter.join();
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_GT(json::parse(*status)["server"]["epoch"], before);
}

TEST(RequestsOverDds, NoServerIsUnavailable) {
  Domain domain;
  client::ClientOptions options;
  options.domain = domain.number();
  options.user = "ada";
  options.timeout = std::chrono::milliseconds(700);
  const auto start = Clock::now();
  auto none = client::Client::connect(options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::unavailable);
  EXPECT_NE(none.error().message.find("is tenterd running"), std::string::npos)
      << none.error().message;
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(3));
}

TEST(RequestsOverDds, AnotherNameIsNamed) {
  DaemonOptions named;
  named.name = "lab";
  Daemon daemon(named);
  client::ClientOptions options;
  options.domain = daemon.domain();
  options.user = "ada";
  options.server = "rig";
  options.timeout = std::chrono::milliseconds(700);
  auto none = client::Client::connect(options);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("'lab'"), std::string::npos) << none.error().message;
  options.server = "lab";
  EXPECT_TRUE(client::Client::connect(options));
}

TEST(RequestsOverDds, AServerOfAnotherMajorVersionIsToldApart) {
  Domain domain;
  wire::ParticipantOptions place;
  place.domain = domain.number();
  place.role = wire::Role::server;
  place.name = "new";
  place.software = "9.0";
  place.wire_major = 2;
  auto other = wire::Participant::create(place);
  ASSERT_TRUE(other);
  client::ClientOptions options;
  options.domain = domain.number();
  options.user = "ada";
  options.timeout = std::chrono::milliseconds(700);
  auto none = client::Client::connect(options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::unavailable);
  EXPECT_NE(none.error().message.find("version 2"), std::string::npos) << none.error().message;
}

TEST(RequestsOverDds, TwoDaemonsCannotShareAStore) {
  Daemon daemon;
  const std::string command = std::string(TENTER_TENTERD) + " --store " + daemon.store().string() +
                              " --domain " + std::to_string(daemon.domain()) + " 2>/dev/null";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(ErrorKind::refused));
}

}  // namespace
}  // namespace tenter::test
