// SPDX-License-Identifier: Apache-2.0
// The table of topics: name, quality of service, limits. Every endpoint is made from a row of it.
//
// All names begin with "tenter/v1/" and the requests, replies and chunks end with the user's name,
// so that a permissions file can tell users apart. Durations of 0 mean none.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "common/wire/uuid.h"

namespace tenter::wire {

struct Topic {
  std::string name;
  bool reliable = true;
  bool transient_local = false;  ///< who comes late gets what the history holds
  bool keep_all = false;         ///< else the last `depth` of each instance
  int depth = 1;                 ///< samples of one instance, or of all where the type has no key
  int max_instances = 1;         ///< of types with a key
  std::chrono::milliseconds lifespan{0};
  std::chrono::milliseconds liveliness{0};
  bool large = false;  ///< megabytes: payloads are kept and used again
};

Topic server_topic();
Topic presence_topic();
Topic request_topic(std::string_view user);
Topic reply_topic(std::string_view user);
Topic job_state_topic();
Topic job_event_topic();
Topic fit_progress_topic();
/// One topic for each transfer: with one for all, a stopped client that reads the same topic would
/// hold up the others, since nothing of these may be dropped.
Topic chunk_up_topic(std::string_view user, const Uuid& transfer);
Topic chunk_down_topic(std::string_view user, const Uuid& transfer);
Topic chunk_ack_topic(std::string_view user, const Uuid& transfer);

/// Jobs that job_state and fit_progress hold at a time; the publisher lets the ended ones go
/// before.
inline constexpr int kMaxJobInstances = 4096;
/// Transfers of one user at a time, in each direction.
inline constexpr int kMaxTransfers = 16;

/// The user in a request topic's name; "" if the name is not one of ours.
std::string_view user_of_request_topic(std::string_view name);

/// 1..32 of A-Z a-z 0-9 _ - . and not starting with a dot or a dash.
bool is_user_name(std::string_view user);

}  // namespace tenter::wire
