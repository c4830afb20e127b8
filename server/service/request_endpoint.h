// SPDX-License-Identifier: GPL-3.0-or-later
// Requests in, replies out: one reader and one writer for each user who shows up.
//
// A user's endpoints are made when a request writer on that user's topic is discovered, and go when
// nobody has been matched for a minute. A request is checked and handed to a work queue under its
// client's key; the same request again is answered from memory, or told that it is being worked on.
// What is malformed, too large or unknown gets a reply that says so. The reply history drops the
// oldest for a client that does not read, so nobody waits for it.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/wire/endpoint.h"
#include "server/service/context.h"
#include "server/service/operations.h"
#include "server/service/reply_cache.h"
#include "server/service/work_queue.h"

namespace tenter::service {

class RequestEndpoint {
 public:
  RequestEndpoint(const Context& context, Operations operations);
  ~RequestEndpoint();

  /// Loop thread: a writer on this topic was discovered.
  void on_remote_writer(const std::string& topic);
  /// Loop thread, now and then.
  void tidy();

 private:
  struct User;
  static constexpr std::size_t kMaxUsers = 64;

  void take(User& user, wire::v1::Request& request, const wire::Peer& peer);
  void start(const std::string& user, const wire::Peer& peer, const Caller& caller,
             const std::string& name, std::vector<std::uint8_t> body);
  void finish(const std::string& user, const wire::Peer& peer, const Caller& caller,
              ReplyText reply);
  void send(User& user, const wire::Peer& peer, const ReplyCache::Key& key, const ReplyText& reply);
  void send_status(User& user, const ReplyCache::Key& key, std::uint32_t status,
                   const std::string& message);
  void on_match(const std::string& user, bool came);

  const Context context_;
  const Operations operations_;
  ReplyCache cache_;
  std::map<std::string, std::unique_ptr<User>> users_;
  std::unique_ptr<WorkQueue> quick_;
  std::unique_ptr<WorkQueue> slow_;
};

}  // namespace tenter::service
