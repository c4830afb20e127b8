// SPDX-License-Identifier: Apache-2.0
// A client's place on the wire: finds its server, keeps track of it, asks and waits for the answer.
//
// A request is sent only once its writer and the reply's reader have both matched the same server.
// It is sent again, under the same identifier, after 1, 2 and 4 seconds, and at once when the
// server was started anew.
#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "client/api/client.h"
#include "common/wire/endpoint.h"

namespace tenter::client {

/// The server that this client talks to, as it announced itself.
struct ServerView {
  wire::Peer peer{};
  wire::Uuid id{};
  std::uint64_t epoch = 0;
  std::string name;
  std::string software;
  bool alive = false;
};

class Connection {
 public:
  /// Joins the domain and waits for the server; joins once more where the two do not match.
  static Expected<std::unique_ptr<Connection>> open(const ClientOptions& options);
  ~Connection();

  /// Sends one request and returns the reply's body.
  Expected<std::string> request(std::string_view operation, const std::string& body,
                                const std::stop_token& stop = {});

  /// Where the server stands now; `alive` is false while it is silent.
  ServerView server() const;
  /// Waits until the server is there and can be asked.
  Expected<ServerView> wait_for_server(const std::stop_token& stop = {});

  const ClientOptions& options() const { return options_; }
  wire::Participant& participant() { return *participant_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Pending {
    std::vector<std::optional<std::vector<std::uint8_t>>> parts;
    std::uint32_t status = 0;
    std::string message;
    bool working = false;  ///< said so since this was last looked at
    bool done = false;
  };

  explicit Connection(ClientOptions options);
  Expected<void> join();
  void leave();
  Expected<ServerView> wait_for_server(Clock::time_point deadline,
                                       const std::stop_token& stop = {});
  void meet(const ServerView& server);  ///< with mutex_
  void take(wire::v1::Server& sample, const wire::Peer& peer);
  void take(wire::v1::Reply& sample);
  void set_alive(const wire::Peer& peer, bool alive);
  void announce();
  bool usable_locked() const;
  std::string why_no_server() const;
  Expected<std::string> result_of(Pending& pending) const;

  const ClientOptions options_;
  wire::Uuid client_id_{};
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<wire::Uuid, ServerView> servers_;
  std::map<wire::Peer, wire::PeerInfo> peers_;  ///< server participants, of any version
  std::optional<wire::Uuid> chosen_;
  std::map<wire::Uuid, Pending> pending_;
  std::uint64_t proven_epoch_ = 0;  ///< of the server that answered last

  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<wire::Writer<wire::v1::Presence>> presence_;
  std::unique_ptr<wire::Reader<wire::v1::Reply>> replies_;
  std::unique_ptr<wire::Writer<wire::v1::Request>> requests_;
  std::unique_ptr<wire::Reader<wire::v1::Server>> announcements_;
  wire::Loop::TimerId timer_ = 0;
};

}  // namespace tenter::client
