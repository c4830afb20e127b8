// SPDX-License-Identifier: Apache-2.0
// Replies as JSON: read with care, because what comes off the wire is only known to be text.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "client/api/connection.h"

namespace tenter::client {

using nlohmann::json;

/// One object, else an Error that names the operation.
inline Expected<json> parse_reply(std::string_view operation, const std::string& text) {
  json reply = json::parse(text, nullptr, false);
  if (!reply.is_object())
    return fail(ErrorKind::internal,
                "the server's reply to " + std::string(operation) + " is not a JSON object");
  return reply;
}

inline Expected<json> ask(Connection& connection, std::string_view operation, const json& body,
                          const std::stop_token& stop = {}) {
  auto text = connection.request(operation,
                                 body.dump(-1, ' ', false, json::error_handler_t::replace), stop);
  if (!text) return tl::unexpected(text.error());
  return parse_reply(operation, *text);
}

inline std::string text_at(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

inline std::uint64_t count_at(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

inline bool flag_at(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

}  // namespace tenter::client
