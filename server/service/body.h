// SPDX-License-Identifier: GPL-3.0-or-later
// The JSON bodies of requests: read with care, written from the records of the queue.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/types.h"

namespace tenter::service {

/// One object of at most 64 levels, else bad_input. An empty body is {}.
Expected<nlohmann::json> parse_body(std::string_view text);

// A member by its key; missing and null are the same. Errors name the key.
Expected<std::optional<std::string>> optional_text(const nlohmann::json& body, const char* key);
Expected<std::string> required_text(const nlohmann::json& body, const char* key);
Expected<std::optional<std::int64_t>> optional_integer(const nlohmann::json& body, const char* key,
                                                       std::int64_t least, std::int64_t most);
Expected<std::int64_t> required_integer(const nlohmann::json& body, const char* key,
                                        std::int64_t least, std::int64_t most);
Expected<std::optional<double>> optional_number(const nlohmann::json& body, const char* key);
/// A job's id, given as text or as a number.
Expected<jobs::JobId> required_job(const nlohmann::json& body, const char* key);
Expected<std::vector<jobs::JobId>> optional_jobs(const nlohmann::json& body, const char* key);

nlohmann::json to_json(const jobs::JobRecord& job);
nlohmann::json to_json(const jobs::JobEvent& event);
nlohmann::json to_json(const jobs::CaptureRecord& capture);

}  // namespace tenter::service
