// SPDX-License-Identifier: Apache-2.0
// Connecting to a server that is there but does not match whoever joins first, as discovery leaves
// it where a message was lost for good.
#include <gtest/gtest.h>

#include <set>

#include "client/api/client.h"
#include "common/wire/endpoint.h"
#include "common/wire/validate.h"
#include "tests/common/wire/domain.h"

namespace tenter::client {
namespace {

namespace v1 = wire::v1;
using std::chrono::milliseconds;

/// Announces itself, and has its topics only from the `matching`-th client that joins on.
class ReluctantServer {
 public:
  ReluctantServer(int domain, std::size_t matching) : matching_(matching) {
    wire::ParticipantOptions place;
    place.domain = domain;
    place.role = wire::Role::server;
    place.name = "reluctant";
    place.server_id = wire::to_text(id_);
    place.epoch = 1;
    place.on_peer = [this](const wire::PeerInfo& info, bool came) {
      if (!came || info.role != wire::Role::client || !joined_.insert(info.peer).second) return;
      if (joined_.size() == matching_) serve();
    };
    participant_ = std::move(wire::Participant::create(std::move(place)).value());
  }
  ~ReluctantServer() {
    participant_->loop().run([this] {
      requests_.reset();
      replies_.reset();
    });
    participant_.reset();
  }

  std::size_t joined() {
    std::size_t count = 0;
    participant_->loop().run([&] { count = joined_.size(); });
    return count;
  }

 private:
  void serve() {
    replies_ = std::make_unique<wire::Writer<v1::Reply>>(*participant_, wire::reply_topic("ada"),
                                                         wire::MatchHandler{}, 1);
    wire::ReaderHandlers<v1::Request> handlers;
    handlers.on_sample = [this](v1::Request& request, const wire::Peer&) {
      v1::Reply reply;
      reply.client_id(request.client_id());
      reply.request_id(request.request_id());
      reply.parts(1);
      reply.body({'{', '}'});
      EXPECT_TRUE(replies_->write(reply));
    };
    requests_ = std::make_unique<wire::Reader<v1::Request>>(
        *participant_, wire::request_topic("ada"), std::move(handlers));
  }

  const wire::Uuid id_ = wire::random_uuid();
  const std::size_t matching_;
  std::set<wire::Peer> joined_;  ///< loop thread
  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<wire::Writer<v1::Reply>> replies_;
  std::unique_ptr<wire::Reader<v1::Request>> requests_;
};

ClientOptions ada_in(int domain, milliseconds timeout) {
  ClientOptions options;
  options.domain = domain;
  options.user = "ada";
  options.timeout = timeout;
  return options;
}

TEST(Connect, JoinsAgainWhereTheServerDoesNotMatch) {
  const test::Domain domain;
  ReluctantServer server(domain.number(), 2);
  auto client = Client::connect(ada_in(domain.number(), milliseconds(10000)));
  ASSERT_TRUE(client) << client.error().message;
  EXPECT_EQ(server.joined(), 2u);
  const auto jobs = client->list_jobs();
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_EQ(*jobs, "{}");
}

TEST(Connect, AServerThatNeverMatchesIsNamedInTime) {
  const test::Domain domain;
  ReluctantServer server(domain.number(), 100);
  const auto start = std::chrono::steady_clock::now();
  const auto client = Client::connect(ada_in(domain.number(), milliseconds(4000)));
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().kind, ErrorKind::unavailable);
  EXPECT_NE(client.error().message.find("does not take requests of user ada within 4 s"),
            std::string::npos)
      << client.error().message;
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds(8000));
}

}  // namespace
}  // namespace tenter::client
