// SPDX-License-Identifier: Apache-2.0
#include "common/wire/topics.h"

#include <algorithm>
#include <cctype>

#include "tenter_v1.h"

namespace tenter::wire {
namespace {

using std::chrono::milliseconds;

constexpr std::string_view kPrefix = "tenter/v1/";
constexpr std::string_view kRequest = "request/";

std::string named(std::string_view name) {
  return std::string(kPrefix) + std::string(name);
}
std::string named(std::string_view name, std::string_view user) {
  return named(name) + std::string(user);
}

Topic chunk_topic(std::string_view name, std::string_view user, const Uuid& transfer) {
  return {.name = named(name, user) + '/' + to_text(transfer),
          .transient_local = true,
          .keep_all = true,
          .depth = v1::CHUNK_WINDOW,
          .large = true};
}

}  // namespace

Topic server_topic() {
  return {.name = named("server"),
          .transient_local = true,
          .max_instances = 16,
          .liveliness = milliseconds(5000)};
}

Topic presence_topic() {
  return {.name = named("presence"),
          .depth = 256,
          .lifespan = milliseconds(10000),
          .liveliness = milliseconds(5000)};
}

// A reply in parts may take 64 places, and all clients of one user share the history.
Topic request_topic(std::string_view user) {
  return {.name = named(kRequest, user), .depth = 256, .lifespan = milliseconds(30000)};
}

Topic reply_topic(std::string_view user) {
  return {.name = named("reply/", user), .depth = 256, .lifespan = milliseconds(30000)};
}

Topic job_state_topic() {
  return {.name = named("job_state"), .transient_local = true, .max_instances = kMaxJobInstances};
}

Topic job_event_topic() {
  return {.name = named("job_event"), .depth = 256};
}

Topic fit_progress_topic() {
  return {
      .name = named("fit_progress"), .transient_local = true, .max_instances = kMaxJobInstances};
}

Topic chunk_up_topic(std::string_view user, const Uuid& transfer) {
  return chunk_topic("chunk_up/", user, transfer);
}

Topic chunk_down_topic(std::string_view user, const Uuid& transfer) {
  return chunk_topic("chunk_down/", user, transfer);
}

Topic chunk_ack_topic(std::string_view user, const Uuid& transfer) {
  return {.name = named("chunk_ack/", user) + '/' + to_text(transfer), .transient_local = true};
}

std::string_view user_of_request_topic(std::string_view name) {
  const std::string prefix = named(kRequest);
  if (!name.starts_with(prefix)) return {};
  const std::string_view user = name.substr(prefix.size());
  return is_user_name(user) ? user : std::string_view{};
}

bool is_user_name(std::string_view user) {
  if (user.empty() || user.size() > v1::MAX_USER || user[0] == '.' || user[0] == '-') return false;
  return std::all_of(user.begin(), user.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.';
  });
}

}  // namespace tenter::wire
