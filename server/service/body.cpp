// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/body.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace tenter::service {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 64;

// Levels of brackets outside of strings; enough to refuse what would exhaust the stack later.
int depth_of(std::string_view text) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{' || c == '[') deepest = std::max(deepest, ++depth);
    if (c == '}' || c == ']') --depth;
  }
  return deepest;
}

std::string quoted(const char* key) {
  return '"' + std::string(key) + '"';
}

const json* member(const json& body, const char* key) {
  const auto found = body.find(key);
  return found == body.end() || found->is_null() ? nullptr : &*found;
}

json or_null(const std::string& text) {
  return text.empty() ? json() : json(text);
}
json or_null(std::int64_t time_ms) {
  return time_ms == 0 ? json() : json(time_ms);
}

json id_list(const std::vector<jobs::JobId>& ids) {
  json list = json::array();
  for (jobs::JobId id : ids) list.push_back(jobs::job_id_text(id));
  return list;
}

json progress_json(const jobs::JobProgress& progress) {
  return {{"stage", progress.stage},
          {"detail", progress.detail},
          {"iteration", progress.iteration},
          {"cost", std::isfinite(progress.cost) ? json(progress.cost) : json()},
          {"fraction", progress.fraction}};
}

}  // namespace

Expected<json> parse_body(std::string_view text) {
  if (text.empty()) return json::object();
  if (depth_of(text) > kMaxDepth)
    return bad_input("the request's body is nested more than " + std::to_string(kMaxDepth) +
                     " levels deep");
  try {
    json body = json::parse(text);
    if (!body.is_object()) return bad_input("the request's body is not a JSON object");
    return body;
  } catch (const json::exception& problem) {
    return bad_input(std::string("the request's body is not JSON: ") + problem.what());
  }
}

Expected<std::optional<std::string>> optional_text(const json& body, const char* key) {
  const json* value = member(body, key);
  if (!value) return std::optional<std::string>();
  if (!value->is_string()) return bad_input("the request's " + quoted(key) + " is not a text");
  return value->get<std::string>();
}

Expected<std::string> required_text(const json& body, const char* key) {
  auto value = optional_text(body, key);
  if (!value) return tl::unexpected(value.error());
  if (!*value || (*value)->empty()) return bad_input("the request has no " + quoted(key));
  return **value;
}

Expected<std::optional<std::int64_t>> optional_integer(const json& body, const char* key,
                                                       std::int64_t least, std::int64_t most) {
  const json* value = member(body, key);
  if (!value) return std::optional<std::int64_t>();
  const bool huge =
      value->is_number_unsigned() &&
      value->get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  if (!value->is_number_integer() || huge)
    return bad_input("the request's " + quoted(key) + " is not a whole number");
  const auto number = value->get<std::int64_t>();
  if (number < least || number > most)
    return bad_input("the request's " + quoted(key) + " is " + std::to_string(number) +
                     ", not within " + std::to_string(least) + " to " + std::to_string(most));
  return number;
}

Expected<std::int64_t> required_integer(const json& body, const char* key, std::int64_t least,
                                        std::int64_t most) {
  auto value = optional_integer(body, key, least, most);
  if (!value) return tl::unexpected(value.error());
  if (!*value) return bad_input("the request has no " + quoted(key));
  return **value;
}

Expected<std::optional<double>> optional_number(const json& body, const char* key) {
  const json* value = member(body, key);
  if (!value) return std::optional<double>();
  if (!value->is_number()) return bad_input("the request's " + quoted(key) + " is not a number");
  return value->get<double>();
}

Expected<jobs::JobId> required_job(const json& body, const char* key) {
  const json* value = member(body, key);
  if (!value) return bad_input("the request has no " + quoted(key));
  if (value->is_number())
    return required_integer(body, key, 1, std::numeric_limits<std::int64_t>::max());
  if (!value->is_string())
    return bad_input("the request's " + quoted(key) + " is not a job's number");
  return jobs::parse_job_id(value->get<std::string>());
}

Expected<std::vector<jobs::JobId>> optional_jobs(const json& body, const char* key) {
  std::vector<jobs::JobId> ids;
  const json* value = member(body, key);
  if (!value) return ids;
  if (!value->is_array()) return bad_input("the request's " + quoted(key) + " is not a list");
  for (const json& one : *value) {
    auto id = required_job(json{{key, one}}, key);
    if (!id) return tl::unexpected(id.error());
    ids.push_back(*id);
  }
  return ids;
}

json to_json(const jobs::JobRecord& job) {
  json out = {{"id", jobs::job_id_text(job.id)},
              {"kind", job.kind},
              {"user", job.user},
              {"state", jobs::name_of(job.state)},
              {"priority", job.priority},
              {"revision", job.revision},
              {"attempt", job.attempt},
              {"worker_deaths", job.worker_deaths},
              {"retries", job.retries},
              {"created_ms", job.created_ms},
              {"started_ms", or_null(job.started_ms)},
              {"ended_ms", or_null(job.ended_ms)},
              {"message", job.message},
              {"from_store", job.from_store},
              {"captures", job.captures},
              {"depends_on", id_list(job.depends_on)},
              {"limits",
               {{"time_s", job.time_limit_s},
                {"memory_bytes", job.memory_limit_bytes},
                {"attempts", job.max_attempts}}},
              {"spec_sha256", job.spec_sha256},
              {"result_sha256", or_null(job.result_sha256)},
              {"residuals_sha256", or_null(job.residuals_sha256)},
              {"frames_sha256", or_null(job.frames_sha256)},
              {"progress", job.progress ? progress_json(*job.progress) : json()},
              {"error", json()}};
  if (job.error)
    out["error"] = {{"kind", jobs::name_of(job.error->kind)}, {"message", job.error->message}};
  if (!job.spec_json.empty()) out["spec"] = json::parse(job.spec_json, nullptr, false);
  return out;
}

json to_json(const jobs::JobEvent& event) {
  return {{"number", event.number},   {"what", event.what},
          {"message", event.message}, {"state", jobs::name_of(event.state)},
          {"attempt", event.attempt}, {"time_ms", event.time_ms}};
}

json to_json(const jobs::CaptureRecord& capture) {
  json summary = json::parse(capture.summary_json, nullptr, false);
  return {{"id", capture.sha256},
          {"kind", capture.kind},
          {"title", capture.title},
          {"user", capture.user},
          {"created_ms", capture.created_ms},
          {"bytes", capture.size_bytes},
          {"summary", summary.is_object() ? std::move(summary) : json::object()}};
}

}  // namespace tenter::service
