// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/request_endpoint.h"

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/wire/topics.h"
#include "common/wire/validate.h"
#include "server/service/body.h"

namespace tenter::service {

namespace v1 = wire::v1;
using Clock = std::chrono::steady_clock;

// A reply may be ready before the client's reader is matched here, although the client saw both
// matched; it waits that long.
constexpr auto kHold = std::chrono::seconds(2);
constexpr auto kForgetUser = std::chrono::seconds(60);

struct RequestEndpoint::User {
  struct Held {
    wire::Peer peer;
    ReplyCache::Key key;
    ReplyText reply;
    Clock::time_point since;
  };

  std::string name;
  std::deque<Held> held;
  Clock::time_point last_seen = Clock::now();
  std::unique_ptr<wire::Writer<v1::Reply>> replies;
  std::unique_ptr<wire::Reader<v1::Request>> requests;  ///< last: gone first
};

RequestEndpoint::RequestEndpoint(const Context& context, Operations operations)
    : context_(context),
      operations_(std::move(operations)),
      quick_(std::make_unique<WorkQueue>(
          WorkQueue::Limits{.threads = 2, .per_key = 64, .total = 4096})),
      slow_(std::make_unique<WorkQueue>(
          WorkQueue::Limits{.threads = 4, .per_key = 16, .total = 512})) {}

RequestEndpoint::~RequestEndpoint() {
  quick_.reset();
  slow_.reset();
  context_.participant.loop().run([this] { users_.clear(); });  // after all that they posted
}

void RequestEndpoint::on_remote_writer(const std::string& topic) {
  const std::string name(wire::user_of_request_topic(topic));
  if (name.empty() || users_.count(name) > 0) return;
  if (users_.size() >= kMaxUsers) {
    context_.log(Level::warning, "user " + name + " is not served: " + std::to_string(kMaxUsers) +
                                     " users are connected already");
    return;
  }
  auto user = std::make_unique<User>();
  user->name = name;
  User* const raw = user.get();
  users_[name] = std::move(user);
  raw->replies = std::make_unique<wire::Writer<v1::Reply>>(
      context_.participant, wire::reply_topic(name),
      [this, name](const wire::Peer&, bool came) { on_match(name, came); }, context_.epoch);
  wire::ReaderHandlers<v1::Request> handlers;
  handlers.on_sample = [this, raw](v1::Request& request, const wire::Peer& peer) {
    take(*raw, request, peer);
  };
  handlers.on_refused = [this, raw](v1::Request& request, const wire::Peer& peer,
                                    const std::string& why) {
    if (request.server_id() != context_.server_id) return;
    const ReplyCache::Key key{request.client_id(), request.request_id()};
    send(*raw, peer, key,
         {.ok = false,
          .kind = ErrorKind::bad_input,
          .message = "the request was refused: its " + why,
          .body = {}});
  };
  raw->requests = std::make_unique<wire::Reader<v1::Request>>(
      context_.participant, wire::request_topic(name), std::move(handlers));
}

void RequestEndpoint::take(User& user, v1::Request& request, const wire::Peer& peer) {
  if (request.server_id() != context_.server_id) return;  // another server's
  user.last_seen = Clock::now();
  const ReplyCache::Key key{request.client_id(), request.request_id()};
  const ReplyCache::Look look = cache_.look(key);
  if (look.known == ReplyCache::Known::answered) return send(user, peer, key, *look.reply);
  if (look.known == ReplyCache::Known::working)
    return send_status(user, key, v1::STATUS_WORKING, "");
  start(user.name, peer, {user.name, request.client_id(), request.request_id()},
        request.operation(), std::move(request.body()));
}

void RequestEndpoint::start(const std::string& user, const wire::Peer& peer, const Caller& caller,
                            const std::string& name, std::vector<std::uint8_t> body) {
  const auto found = operations_.find(name);
  if (found == operations_.end())
    return finish(user, peer, caller,
                  {.ok = false,
                   .kind = ErrorKind::not_found,
                   .message = "this server has no operation '" + name + "'",
                   .body = {}});
  const Operation& operation = found->second;
  auto work = [this, &operation, user, peer, caller, body = std::move(body)] {
    ReplyText reply;
    try {
      auto result = [&]() -> Expected<nlohmann::json> {
        auto parsed = parse_body({reinterpret_cast<const char*>(body.data()), body.size()});
        if (!parsed) return tl::unexpected(parsed.error());
        return operation.function(caller, *parsed);
      }();
      reply.ok = result.has_value();
      if (result) {
        reply.body = result->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      } else {
        reply.kind = result.error().kind;
        reply.message = result.error().message;
      }
    } catch (const std::exception& problem) {
      reply = {.ok = false,
               .kind = ErrorKind::internal,
               .message = std::string("the server failed on this request: ") + problem.what(),
               .body = {}};
    }
    context_.participant.loop().post([this, user, peer, caller, reply = std::move(reply)] {
      finish(user, peer, caller, reply);
    });
  };
  WorkQueue& queue = operation.slow ? *slow_ : *quick_;
  if (queue.add(wire::to_text(caller.client), std::move(work))) return;
  cache_.forget({caller.client, caller.request});
  const auto known = users_.find(user);
  if (known != users_.end())
    send(*known->second, peer, {caller.client, caller.request},
         {.ok = false,
          .kind = ErrorKind::refused,
          .message = "too many requests of this client are waiting; try again later",
          .body = {}});
}

void RequestEndpoint::finish(const std::string& user, const wire::Peer& peer, const Caller& caller,
                             ReplyText reply) {
  constexpr std::size_t kLargest = std::size_t{v1::MAX_BODY} * v1::MAX_REPLY_PARTS;
  if (reply.body.size() > kLargest)
    reply = {.ok = false,
             .kind = ErrorKind::refused,
             .message = "the answer has " + std::to_string(reply.body.size()) +
                        " bytes, more than a reply can carry; ask for less at a time",
             .body = {}};
  const ReplyCache::Key key{caller.client, caller.request};
  const auto kept = std::make_shared<const ReplyText>(std::move(reply));
  cache_.answer(key, kept, Clock::now());
  const auto found = users_.find(user);
  if (found != users_.end()) send(*found->second, peer, key, *kept);
}

void RequestEndpoint::send(User& user, const wire::Peer& peer, const ReplyCache::Key& key,
                           const ReplyText& reply) {
  if (!user.replies->matched(peer)) {
    if (user.held.size() < 256) user.held.push_back({peer, key, reply, Clock::now()});
    return;
  }
  if (!reply.ok)
    return send_status(user, key, static_cast<std::uint32_t>(reply.kind), reply.message);
  const std::size_t parts =
      std::max<std::size_t>(1, (reply.body.size() + v1::MAX_BODY - 1) / v1::MAX_BODY);
  for (std::size_t part = 0; part < parts; ++part) {
    v1::Reply sample;
    sample.client_id(key.first);
    sample.request_id(key.second);
    sample.part(static_cast<std::uint16_t>(part));
    sample.parts(static_cast<std::uint16_t>(parts));
    const std::size_t begin = part * v1::MAX_BODY;
    const std::size_t end = std::min(begin + v1::MAX_BODY, reply.body.size());
    sample.body().assign(reply.body.begin() + static_cast<std::ptrdiff_t>(begin),
                         reply.body.begin() + static_cast<std::ptrdiff_t>(end));
    if (auto sent = user.replies->write(sample); !sent)
      return context_.log(Level::warning, sent.error().message);
  }
}

void RequestEndpoint::send_status(User& user, const ReplyCache::Key& key, std::uint32_t status,
                                  const std::string& message) {
  v1::Reply sample;
  sample.client_id(key.first);
  sample.request_id(key.second);
  sample.parts(1);
  sample.status(status);
  sample.message(wire::clean_text(message, v1::MAX_TEXT));
  if (auto sent = user.replies->write(sample); !sent)
    context_.log(Level::warning, sent.error().message);
}

void RequestEndpoint::on_match(const std::string& name, bool came) {
  const auto found = users_.find(name);
  if (found == users_.end()) return;
  User& user = *found->second;
  user.last_seen = Clock::now();
  if (!came) return;
  std::deque<User::Held> held;
  held.swap(user.held);
  for (User::Held& one : held) send(user, one.peer, one.key, one.reply);
}

void RequestEndpoint::tidy() {
  const auto now = Clock::now();
  cache_.tidy(now);
  for (auto one = users_.begin(); one != users_.end();) {
    User& user = *one->second;
    while (!user.held.empty() && now - user.held.front().since > kHold) user.held.pop_front();
    if (user.replies->matched_count() > 0) user.last_seen = now;
    if (now - user.last_seen > kForgetUser)
      one = users_.erase(one);
    else
      ++one;
  }
}

}  // namespace tenter::service
