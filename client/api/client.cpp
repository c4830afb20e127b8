// SPDX-License-Identifier: Apache-2.0
#include "client/api/client.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "client/api/connection.h"
#include "client/api/download.h"
#include "client/api/json_body.h"
#include "client/api/upload.h"
#include "client/api/watch.h"

namespace tenter::client {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string login_name() {
  char buffer[4096];
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(::geteuid(), &entry, buffer, sizeof buffer, &found) == 0 && found)
    return found->pw_name;
  return "uid" + std::to_string(::geteuid());
}

// What the options leave open, from the environment.
Expected<ClientOptions> complete(ClientOptions options) {
  auto domain = wire::domain_or_default(options.domain);
  if (!domain) return tl::unexpected(domain.error());
  options.domain = *domain;
  if (options.server.empty()) options.server = environment("TENTER_SERVER");
  if (options.user.empty()) options.user = environment("TENTER_USER");
  if (options.user.empty()) options.user = login_name();
  if (!wire::is_user_name(options.user))
    return bad_input("the user's name '" + options.user +
                     "' is not 1 to 32 letters, digits, '_', '-' or '.', the first a letter, digit "
                     "or '_'");
  options.timeout = std::clamp(options.timeout, std::chrono::milliseconds(100),
                               std::chrono::milliseconds(3600000));
  return options;
}

}  // namespace

std::string_view job_state_name(JobState state) {
  switch (state) {
    case JobState::queued:
      return "queued";
    case JobState::running:
      return "running";
    case JobState::succeeded:
      return "succeeded";
    case JobState::failed:
      return "failed";
    case JobState::cancelled:
      return "cancelled";
  }
  return "unknown";
}

class Client::Impl {
 public:
  std::unique_ptr<Connection> connection;

  Expected<std::string> ask_text(std::string_view operation, const json& body) {
    auto reply = ask(*connection, operation, body);
    if (!reply) return tl::unexpected(reply.error());
    return reply->dump();
  }
};

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

Expected<Client> Client::connect(const ClientOptions& options) {
  auto all = complete(options);
  if (!all) return tl::unexpected(all.error());
  auto connection = Connection::open(*all);
  if (!connection) return tl::unexpected(connection.error());
  auto impl = std::make_unique<Impl>();
  impl->connection = std::move(*connection);
  return Client(std::move(impl));
}

const std::string& Client::user() const {
  return impl_->connection->options().user;
}
int Client::domain() const {
  return *impl_->connection->options().domain;
}

Expected<std::string> Client::server_status() {
  return impl_->ask_text("server.status", json::object());
}

Expected<UploadResult> Client::upload_capture(const std::filesystem::path& path,
                                              const TransferCallback& progress,
                                              const std::stop_token& stop) {
  return upload(*impl_->connection, path, progress, stop);
}

Expected<std::string> Client::list_captures(int limit, const std::string& cursor) {
  json body = {{"limit", limit}};
  if (!cursor.empty()) body["cursor"] = cursor;
  return impl_->ask_text("capture.list", body);
}

Expected<std::string> Client::show_capture(const std::string& sha256) {
  return impl_->ask_text("capture.show", {{"capture", sha256}});
}

Expected<std::uint64_t> Client::download_capture(const std::string& sha256,
                                                 const std::filesystem::path& destination,
                                                 const TransferCallback& progress,
                                                 const std::stop_token& stop) {
  return download(*impl_->connection, {{}, {}, sha256}, destination, progress, stop);
}

Expected<SubmitResult> Client::submit(const SubmitRequest& request) {
  json spec = json::parse(request.spec_json, nullptr, false);
  if (!spec.is_object()) return bad_input("the job's specification is not a JSON object");
  json body = {{"spec", std::move(spec)}, {"priority", request.priority}};
  body["request_id"] =
      request.request_id.empty() ? wire::to_text(wire::random_uuid()) : request.request_id;
  if (!request.depends_on.empty()) body["depends_on"] = request.depends_on;
  if (request.time_limit_s) body["time_limit_s"] = *request.time_limit_s;
  if (request.memory_limit_bytes) body["memory_limit_bytes"] = *request.memory_limit_bytes;
  if (request.max_attempts) body["max_attempts"] = *request.max_attempts;
  auto reply = ask(*impl_->connection, "job.submit", body);
  if (!reply) return tl::unexpected(reply.error());
  const json job = reply->value("job", json::object());
  SubmitResult result;
  result.job_id = text_at(job, "id");
  result.repeated = flag_at(*reply, "repeated");
  result.from_store = flag_at(job, "from_store");
  result.job_json = job.dump();
  if (result.job_id.empty())
    return fail(ErrorKind::internal, "the server's reply to job.submit names no job");
  return result;
}

Expected<std::string> Client::list_jobs(const JobFilter& filter) {
  json body = {{"limit", filter.limit}};
  if (!filter.user.empty()) body["user"] = filter.user;
  if (!filter.state.empty()) body["state"] = filter.state;
  if (!filter.kind.empty()) body["kind"] = filter.kind;
  if (!filter.cursor.empty()) body["cursor"] = filter.cursor;
  return impl_->ask_text("job.list", body);
}

Expected<std::string> Client::show_job(const std::string& job_id) {
  return impl_->ask_text("job.show", {{"job", job_id}});
}

Expected<std::string> Client::job_log(const std::string& job_id, std::size_t bytes) {
  return impl_->ask_text("job.log", {{"job", job_id}, {"bytes", bytes}});
}

Expected<std::string> Client::cancel(const std::string& job_id) {
  return impl_->ask_text("job.cancel", {{"job", job_id}});
}

Expected<std::string> Client::retry(const std::string& job_id) {
  return impl_->ask_text("job.retry", {{"job", job_id}});
}

Expected<JobUpdate> Client::watch(const std::string& job_id, const WatchCallback& callback,
                                  const std::stop_token& stop) {
  return client::watch(*impl_->connection, job_id, callback, stop);
}

Expected<std::uint64_t> Client::fetch_result(const std::string& job_id,
                                             const std::filesystem::path& destination,
                                             const TransferCallback& progress,
                                             const std::stop_token& stop) {
  return download(*impl_->connection, {job_id, "result.json", {}}, destination, progress, stop);
}

Expected<std::uint64_t> Client::fetch_residuals(const std::string& job_id,
                                                const std::filesystem::path& destination,
                                                const TransferCallback& progress,
                                                const std::stop_token& stop) {
  return download(*impl_->connection, {job_id, "residuals.h5", {}}, destination, progress, stop);
}

Expected<std::uint64_t> Client::fetch_frames(const std::string& job_id,
                                             const std::filesystem::path& destination,
                                             const TransferCallback& progress,
                                             const std::stop_token& stop) {
  return download(*impl_->connection, {job_id, "frames.h5", {}}, destination, progress, stop);
}

Expected<std::string> Client::request(const std::string& operation, const std::string& body_json) {
  auto text = impl_->connection->request(operation, body_json);
  if (!text) return tl::unexpected(text.error());
  auto reply = parse_reply(operation, *text);
  if (!reply) return tl::unexpected(reply.error());
  return *text;
}

}  // namespace tenter::client
