// SPDX-License-Identifier: Apache-2.0
#include "client/api/connection.h"

#include <unistd.h>

#include <algorithm>

#include "common/wire/validate.h"

namespace tenter::client {

namespace v1 = wire::v1;

namespace {

constexpr auto kPresenceEvery = std::chrono::seconds(2);
// Server and client match within tenths of a second. Once in thousands of starts on a busy machine
// they never do: discovery then waits for a message that the other side does not send again. Only a
// new participant helps.
constexpr auto kJoinAgainAfter = std::chrono::seconds(3);
constexpr std::chrono::milliseconds kResend[] = {std::chrono::seconds(1), std::chrono::seconds(2),
                                                 std::chrono::seconds(4)};
// Both sides match in their own time: what arrives at an endpoint that has not matched its sender
// yet is lost. So until the first reply of this server, a request is sent again much sooner.
constexpr auto kFirstResend = std::chrono::milliseconds(15);

std::chrono::milliseconds pause_after(std::size_t sent, bool proven) {
  if (proven) return kResend[std::min<std::size_t>(sent, std::size(kResend) - 1)];
  return std::min(kFirstResend * (1 << std::min<std::size_t>(sent, 8)), kResend[0]);
}

std::string seconds_text(std::chrono::milliseconds time) {
  std::string text = std::to_string(static_cast<double>(time.count()) / 1000.0);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text + " s";
}

ErrorKind kind_of(std::uint32_t status) {
  const auto last = static_cast<std::uint32_t>(ErrorKind::cancelled);
  return status >= 1 && status <= last ? static_cast<ErrorKind>(status) : ErrorKind::internal;
}

}  // namespace

Connection::Connection(ClientOptions options)
    : options_(std::move(options)), client_id_(wire::random_uuid()) {}

Connection::~Connection() {
  leave();
}

void Connection::leave() {
  if (!participant_) return;
  participant_->loop().cancel(timer_);
  announcements_.reset();
  replies_.reset();
  requests_.reset();
  presence_.reset();
  participant_.reset();
  servers_.clear();
  peers_.clear();
  chosen_.reset();
}

Expected<std::unique_ptr<Connection>> Connection::open(const ClientOptions& options) {
  auto connection = std::unique_ptr<Connection>(new Connection(options));
  const auto deadline = Clock::now() + options.timeout;
  const auto patience = Clock::now() + kJoinAgainAfter;
  if (auto joined = connection->join(); !joined) return tl::unexpected(joined.error());
  auto server = connection->wait_for_server(std::min(patience, deadline));
  if (!server && patience < deadline) {
    connection->leave();
    if (auto joined = connection->join(); !joined) return tl::unexpected(joined.error());
    server = connection->wait_for_server(deadline);
  }
  if (!server) return tl::unexpected(server.error());
  return connection;
}

Expected<void> Connection::join() {
  wire::ParticipantOptions place;
  place.domain = *options_.domain;
  place.role = wire::Role::client;
  place.name = options_.name;
  place.on_peer = [this](const wire::PeerInfo& info, bool came) {
    std::lock_guard lock(mutex_);
    if (info.role != wire::Role::server) return;
    if (came && peers_.emplace(info.peer, info).second) {
      const auto id = wire::parse_uuid(info.server_id);
      if (id && info.wire_major == v1::WIRE_MAJOR)
        meet({info.peer, *id, info.epoch, info.name, info.software, true});
    } else if (!came) {
      peers_.erase(info.peer);
    }
  };
  auto participant = wire::Participant::create(std::move(place));
  if (!participant) return tl::unexpected(participant.error());
  participant_ = std::move(*participant);

  const auto wake = [this](const wire::Peer&, bool) {
    std::lock_guard lock(mutex_);
    changed_.notify_all();
  };
  wire::ReaderHandlers<v1::Reply> on_reply;
  on_reply.on_sample = [this](v1::Reply& sample, const wire::Peer&) { take(sample); };
  on_reply.on_match = wake;
  replies_ = std::make_unique<wire::Reader<v1::Reply>>(
      *participant_, wire::reply_topic(options_.user), std::move(on_reply));
  requests_ = std::make_unique<wire::Writer<v1::Request>>(*participant_,
                                                          wire::request_topic(options_.user), wake);
  wire::ReaderHandlers<v1::Server> on_server;
  on_server.on_sample = [this](v1::Server& sample, const wire::Peer& peer) { take(sample, peer); };
  on_server.on_match = [this](const wire::Peer& peer, bool came) {
    if (!came) set_alive(peer, false);
  };
  on_server.on_alive = [this](const wire::Peer& peer, bool alive) { set_alive(peer, alive); };
  announcements_ = std::make_unique<wire::Reader<v1::Server>>(*participant_, wire::server_topic(),
                                                              std::move(on_server));
  participant_->loop().run([this] {  // so that no match is handled before the writer has its name
    presence_ = std::make_unique<wire::Writer<v1::Presence>>(*participant_, wire::presence_topic(),
                                                             [this](const wire::Peer&, bool came) {
                                                               if (came) announce();
                                                             });
  });
  timer_ = participant_->loop().every(kPresenceEvery, [this] { announce(); });
  return {};
}

void Connection::announce() {
  v1::Presence sample;
  sample.client_id(client_id_);
  sample.user(options_.user);
  sample.name(wire::clean_text(options_.name, v1::MAX_NAME));
  sample.process(static_cast<std::uint32_t>(::getpid()));
  (void)presence_->write(sample);  // said again in two seconds
}

// A server is known by the announcement of its participant, before any of its topics has matched.
void Connection::meet(const ServerView& server) {
  ServerView& view = servers_[server.id];
  if (server.epoch < view.epoch) return;  // the one before it, late
  view = server;
  const bool wanted = options_.server.empty() || options_.server == view.name;
  if (!chosen_ && wanted) chosen_ = view.id;
  changed_.notify_all();
}

void Connection::take(v1::Server& sample, const wire::Peer& peer) {
  std::lock_guard lock(mutex_);
  meet({peer, sample.server_id(), sample.header().epoch(), sample.name(), sample.software(), true});
}

void Connection::set_alive(const wire::Peer& peer, bool alive) {
  std::lock_guard lock(mutex_);
  for (auto& [id, view] : servers_)
    if (view.peer == peer) view.alive = alive;
  changed_.notify_all();
}

void Connection::take(v1::Reply& sample) {
  if (sample.client_id() != client_id_) return;
  std::lock_guard lock(mutex_);
  proven_epoch_ = sample.header().epoch();
  const auto found = pending_.find(sample.request_id());
  if (found == pending_.end() || found->second.done) return;
  Pending& pending = found->second;
  if (sample.status() == v1::STATUS_WORKING) {
    pending.working = true;
  } else {
    if (pending.parts.size() != sample.parts()) pending.parts.assign(sample.parts(), std::nullopt);
    pending.status = sample.status();
    pending.message = sample.message();
    pending.parts[sample.part()] = std::move(sample.body());
    pending.done = std::all_of(pending.parts.begin(), pending.parts.end(),
                               [](const auto& part) { return part.has_value(); });
  }
  changed_.notify_all();
}

bool Connection::usable_locked() const {
  if (!chosen_) return false;
  const ServerView& view = servers_.at(*chosen_);
  return view.alive && requests_->matched(view.peer) && replies_->matched(view.peer);
}

ServerView Connection::server() const {
  std::lock_guard lock(mutex_);
  return chosen_ ? servers_.at(*chosen_) : ServerView{};
}

Expected<ServerView> Connection::wait_for_server(const std::stop_token& stop) {
  return wait_for_server(Clock::now() + options_.timeout, stop);
}

Expected<ServerView> Connection::wait_for_server(Clock::time_point deadline,
                                                 const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const bool there = changed_.wait_until(lock, stop, deadline, [this] { return usable_locked(); });
  if (stop.stop_requested())
    return fail(ErrorKind::cancelled, "stopped while waiting for the server");
  if (!there) return fail(ErrorKind::unavailable, why_no_server());
  return servers_.at(*chosen_);
}

std::string Connection::why_no_server() const {
  const std::string where = "DDS domain " + std::to_string(*options_.domain);
  const std::string time = " within " + seconds_text(options_.timeout);
  if (chosen_)
    return "the server in " + where + " is there but does not take requests of user " +
           options_.user + time;
  for (const auto& [peer, info] : peers_)
    if (info.wire_major != v1::WIRE_MAJOR)
      return "the server in " + where + " (tenterd " + info.software + ") speaks version " +
             std::to_string(info.wire_major) + " of the wire, this client version " +
             std::to_string(v1::WIRE_MAJOR) + ": use programs of the same release";
  if (!servers_.empty()) {
    std::string names;
    for (const auto& [id, view] : servers_)
      names += (names.empty() ? "'" : ", '") + view.name + "'";
    return "no server named '" + options_.server + "' in " + where + "; there is " + names;
  }
  return "no Tenter server answers in " + where + time + "; is tenterd running there?";
}

Expected<std::string> Connection::request(std::string_view operation, const std::string& body,
                                          const std::stop_token& stop) {
  if (body.size() > v1::MAX_BODY)
    return bad_input("the request " + std::string(operation) + " has " +
                     std::to_string(body.size()) + " bytes, more than the " +
                     std::to_string(v1::MAX_BODY) + " that a request can carry");
  v1::Request sample;
  sample.client_id(client_id_);
  sample.request_id(wire::random_uuid());
  sample.operation(std::string(operation));
  sample.body().assign(body.begin(), body.end());

  std::unique_lock lock(mutex_);
  Pending& pending = pending_[sample.request_id()];
  auto deadline = Clock::now() + options_.timeout;
  auto resend = Clock::now();
  std::size_t sent = 0;
  std::uint64_t sent_epoch = 0;
  while (!pending.done && !stop.stop_requested()) {
    const auto now = Clock::now();
    if (pending.working) {
      pending.working = false;
      deadline = std::max(deadline, now + options_.timeout);
    }
    if (now >= deadline) break;
    const bool usable = usable_locked();
    const bool restarted = sent > 0 && usable && servers_.at(*chosen_).epoch != sent_epoch;
    if (usable && (now >= resend || restarted)) {
      sent_epoch = servers_.at(*chosen_).epoch;
      sample.server_id(*chosen_);
      requests_->set_epoch(sent_epoch);
      lock.unlock();
      auto written = requests_->write(sample);
      lock.lock();
      resend = Clock::now() + pause_after(sent, proven_epoch_ == sent_epoch);
      ++sent;
      if (!written) {
        pending_.erase(sample.request_id());
        return tl::unexpected(written.error());
      }
      continue;
    }
    changed_.wait_until(lock, stop, usable ? std::min(resend, deadline) : deadline, [&] {
      return pending.done || pending.working || usable_locked() != usable ||
             (sent > 0 && chosen_ && servers_.at(*chosen_).epoch != sent_epoch && usable_locked());
    });
  }
  Expected<std::string> result;
  if (pending.done)
    result = result_of(pending);
  else if (stop.stop_requested())
    result = fail(ErrorKind::cancelled, "stopped while waiting for the server");
  else if (sent == 0)
    result = fail(ErrorKind::unavailable,
                  "the server is not there any more; waited " + seconds_text(options_.timeout));
  else
    result = fail(ErrorKind::unavailable, "the server did not answer " + std::string(operation) +
                                              " within " + seconds_text(options_.timeout));
  pending_.erase(sample.request_id());
  return result;
}

Expected<std::string> Connection::result_of(Pending& pending) const {
  if (pending.status != 0) return fail(kind_of(pending.status), pending.message);
  std::string body;
  for (const auto& part : pending.parts) body.append(part->begin(), part->end());
  return body;
}

}  // namespace tenter::client
