// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/job_operations.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "server/service/body.h"

namespace tenter::service {
namespace {

using nlohmann::json;

constexpr auto kLargest = std::numeric_limits<std::int64_t>::max();

Expected<std::string> request_id_of(const Caller& caller, const json& body) {
  auto given = optional_text(body, "request_id");
  if (!given) return tl::unexpected(given.error());
  return given->value_or(wire::to_text(caller.request));
}

Expected<json> submit(jobs::JobService& jobs, const Caller& caller, const json& body) {
  jobs::SubmitRequest request;
  request.user = caller.user;
  const auto spec = body.find("spec");
  if (spec == body.end() || !spec->is_object())
    return bad_input("the request has no \"spec\", a job's specification");
  request.spec_json = spec->dump();
  auto request_id = request_id_of(caller, body);
  if (!request_id) return tl::unexpected(request_id.error());
  request.request_id = *request_id;
  auto priority = optional_integer(body, "priority", -100, 100);
  if (!priority) return tl::unexpected(priority.error());
  request.priority = static_cast<int>(priority->value_or(0));
  auto after = optional_jobs(body, "depends_on");
  if (!after) return tl::unexpected(after.error());
  request.depends_on = std::move(*after);
  auto time = optional_number(body, "time_limit_s");
  if (!time) return tl::unexpected(time.error());
  request.time_limit_s = *time;
  auto memory = optional_integer(body, "memory_limit_bytes", 1, kLargest);
  if (!memory) return tl::unexpected(memory.error());
  if (*memory) request.memory_limit_bytes = static_cast<std::uint64_t>(**memory);
  auto attempts = optional_integer(body, "max_attempts", 1, 100);
  if (!attempts) return tl::unexpected(attempts.error());
  if (*attempts) request.max_attempts = static_cast<int>(**attempts);

  auto done = jobs.submit(request);
  if (!done) return tl::unexpected(done.error());
  return json{{"job", to_json(done->job)}, {"repeated", done->repeated}};
}

Expected<json> list(const jobs::JobService& jobs, const json& body) {
  jobs::JobFilter filter;
  auto user = optional_text(body, "user");
  if (!user) return tl::unexpected(user.error());
  filter.user = user->value_or("");
  auto kind = optional_text(body, "kind");
  if (!kind) return tl::unexpected(kind.error());
  filter.kind = kind->value_or("");
  auto capture = optional_text(body, "capture");
  if (!capture) return tl::unexpected(capture.error());
  filter.capture = capture->value_or("");
  auto state = optional_text(body, "state");
  if (!state) return tl::unexpected(state.error());
  if (*state && !(*state)->empty()) {
    filter.state = jobs::job_state_from(**state);
    if (!filter.state)
      return bad_input("the request's \"state\" is '" + **state +
                       "', not one of queued, running, succeeded, failed, cancelled");
  }
  auto limit = optional_integer(body, "limit", 1, 1000);
  if (!limit) return tl::unexpected(limit.error());
  filter.limit = static_cast<int>(limit->value_or(100));
  auto cursor = optional_text(body, "cursor");
  if (!cursor) return tl::unexpected(cursor.error());
  if (*cursor && !(*cursor)->empty()) {
    auto before = jobs::parse_job_id(**cursor);
    if (!before) return bad_input("the request's \"cursor\" is not one of this server's");
    filter.before = *before;
  }
  auto page = jobs.list(filter);
  if (!page) return tl::unexpected(page.error());
  json records = json::array();
  for (const jobs::JobRecord& job : page->jobs) records.push_back(to_json(job));
  return json{
      {"jobs", std::move(records)},
      {"total", page->total},
      {"next", page->next_before == 0 ? json() : json(jobs::job_id_text(page->next_before))}};
}

Expected<json> show(const jobs::JobService& jobs, const json& body) {
  auto id = required_job(body, "job");
  if (!id) return tl::unexpected(id.error());
  auto job = jobs.show(*id);
  if (!job) return tl::unexpected(job.error());
  auto events = jobs.events(*id);
  if (!events) return tl::unexpected(events.error());
  json history = json::array();
  for (const jobs::JobEvent& event : *events) history.push_back(to_json(event));
  json out = to_json(*job);
  out["history"] = std::move(history);
  return out;
}

Expected<json> events(const jobs::JobService& jobs, const json& body) {
  auto id = required_job(body, "job");
  if (!id) return tl::unexpected(id.error());
  auto after = optional_integer(body, "after", 0, kLargest);
  if (!after) return tl::unexpected(after.error());
  auto found = jobs.events(*id, after->value_or(0));
  if (!found) return tl::unexpected(found.error());
  json list = json::array();
  for (const jobs::JobEvent& event : *found) list.push_back(to_json(event));
  return json{{"events", std::move(list)}};
}

Expected<json> log(const jobs::JobService& jobs, const json& body) {
  auto id = required_job(body, "job");
  if (!id) return tl::unexpected(id.error());
  auto bytes = optional_integer(body, "bytes", 1, 1 << 20);
  if (!bytes) return tl::unexpected(bytes.error());
  auto log = jobs.log(*id, static_cast<std::size_t>(bytes->value_or(32768)));
  if (!log) return tl::unexpected(log.error());
  return json{{"text", log->text}, {"truncated", log->truncated}};
}

json state_of(const jobs::JobRecord& job) {
  return {{"job_id", jobs::job_id_text(job.id)}, {"state", jobs::name_of(job.state)}};
}

Expected<json> cancel(jobs::JobService& jobs, const Caller& caller, const json& body) {
  auto id = required_job(body, "job");
  if (!id) return tl::unexpected(id.error());
  auto job = jobs.cancel(caller.user, *id);
  if (!job) return tl::unexpected(job.error());
  return state_of(*job);
}

Expected<json> retry(jobs::JobService& jobs, const Caller& caller, const json& body) {
  auto id = required_job(body, "job");
  if (!id) return tl::unexpected(id.error());
  auto request_id = request_id_of(caller, body);
  if (!request_id) return tl::unexpected(request_id.error());
  auto job = jobs.retry(caller.user, *request_id, *id);
  if (!job) return tl::unexpected(job.error());
  return state_of(*job);
}

Expected<json> list_captures(const jobs::JobService& jobs, const json& body) {
  jobs::CaptureFilter filter;
  auto user = optional_text(body, "user");
  if (!user) return tl::unexpected(user.error());
  filter.user = user->value_or("");
  auto kind = optional_text(body, "kind");
  if (!kind) return tl::unexpected(kind.error());
  filter.kind = kind->value_or("");
  auto limit = optional_integer(body, "limit", 1, 1000);
  if (!limit) return tl::unexpected(limit.error());
  filter.limit = static_cast<int>(limit->value_or(100));
  auto cursor = optional_text(body, "cursor");
  if (!cursor) return tl::unexpected(cursor.error());
  if (*cursor && !(*cursor)->empty()) {
    auto offset = jobs::parse_job_id(**cursor);  // a positive number, as text
    if (!offset) return bad_input("the request's \"cursor\" is not one of this server's");
    filter.offset = *offset;
  }
  auto page = jobs.captures(filter);
  if (!page) return tl::unexpected(page.error());
  json records = json::array();
  for (const jobs::CaptureRecord& capture : page->captures) records.push_back(to_json(capture));
  const std::int64_t seen = filter.offset + static_cast<std::int64_t>(page->captures.size());
  const bool more = seen < page->total && !page->captures.empty();
  return json{{"captures", std::move(records)},
              {"total", page->total},
              {"next", more ? json(std::to_string(seen)) : json()}};
}

Expected<json> show_capture(const jobs::JobService& jobs, const json& body) {
  auto sha256 = required_text(body, "capture");
  if (!sha256) return tl::unexpected(sha256.error());
  auto capture = jobs.capture(*sha256);
  if (!capture) return tl::unexpected(capture.error());
  return to_json(*capture);
}

}  // namespace

void add_job_operations(Operations& table, jobs::JobService& jobs) {
  table["job.submit"] = {[&jobs](const Caller& c, const json& b) { return submit(jobs, c, b); }};
  table["job.list"] = {[&jobs](const Caller&, const json& b) { return list(jobs, b); }};
  table["job.show"] = {[&jobs](const Caller&, const json& b) { return show(jobs, b); }};
  table["job.events"] = {[&jobs](const Caller&, const json& b) { return events(jobs, b); }};
  table["job.log"] = {[&jobs](const Caller&, const json& b) { return log(jobs, b); }};
  table["job.cancel"] = {[&jobs](const Caller& c, const json& b) { return cancel(jobs, c, b); }};
  table["job.retry"] = {[&jobs](const Caller& c, const json& b) { return retry(jobs, c, b); }};
  table["capture.list"] = {
      [&jobs](const Caller&, const json& b) { return list_captures(jobs, b); }};
  table["capture.show"] = {[&jobs](const Caller&, const json& b) { return show_capture(jobs, b); }};
}

}  // namespace tenter::service
