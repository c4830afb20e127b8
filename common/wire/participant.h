// SPDX-License-Identifier: Apache-2.0
// One process's place in a DDS domain: transport, discovery, and the loop that its endpoints live
// on.
//
//   auto participant = Participant::create({.domain = 42, .role = Role::client});
//   Reader<v1::Reply> reader(**participant, reply_topic("ada"), {.on_sample = ...});
//   Writer<v1::Request> writer(**participant, request_topic("ada"));
//
// Traffic stays on 127.0.0.1 unless interfaces are named: by the option, or by
// $TENTER_DDS_INTERFACES
// ("10.0.0.5,127.0.0.1"). This version of Fast DDS has known holes, so other interfaces are for a
// closed network, and they need DDS Security: $TENTER_DDS_SECURITY names a folder, see README.md.
// No shared memory, no data sharing. Nothing is printed; what Fast DDS has to say goes to
// set_wire_log.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/wire/loop.h"

namespace tenter::wire {

inline constexpr int kDefaultDomain = 42;
inline constexpr int kMaxDomain = 232;

/// Names a remote process for as long as it lives: the prefix of its DDS GUID.
using Peer = std::array<std::uint8_t, 12>;

enum class Role { client, server };

/// What a participant tells of itself before any topic matches, whatever its major version.
struct PeerInfo {
  Peer peer{};
  Role role = Role::client;
  int wire_major = 0;
  std::string name;
  std::string software;
  std::string server_id;    ///< of a server: 32 hex digits
  std::uint64_t epoch = 0;  ///< of a server
};

struct ParticipantOptions {
  int domain = kDefaultDomain;
  Role role = Role::client;
  std::string name;
  std::string software;
  std::string server_id;
  std::uint64_t epoch = 0;
  int wire_major = 1;                   ///< a test sets another
  std::vector<std::string> interfaces;  ///< empty: the environment's, else 127.0.0.1
  std::string security;                 ///< folder; "": the environment's, else none
  int lost_percent = 0;  ///< for tests: datagrams to drop; 0: $TENTER_DDS_LOST_PERCENT

  /// Loop thread: a Tenter participant came (true, may be said again) or went (false).
  std::function<void(const PeerInfo&, bool)> on_peer;
  /// Loop thread: some participant has a writer on this topic now.
  std::function<void(const std::string&)> on_remote_writer;
};

class Participant {
 public:
  static Expected<std::unique_ptr<Participant>> create(ParticipantOptions options);
  ~Participant();  ///< its endpoints must be gone
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  Loop& loop();

  class Impl;
  Impl& impl() { return *impl_; }

 private:
  Participant();
  std::unique_ptr<Impl> impl_;
};

/// Domain from an option or $TENTER_DOMAIN or the default; an Error names a bad one.
Expected<int> domain_or_default(std::optional<int> option);

enum class LogLevel { error, warning };
/// Before the first participant; the function is called from a thread of Fast DDS. Default:
/// silence.
void set_wire_log(std::function<void(LogLevel, const std::string&)> log);

}  // namespace tenter::wire
