// SPDX-License-Identifier: Apache-2.0
// The client library: everything a program can ask of a Tenter server, over DDS.
//
//   auto client = tenter::client::Client::connect({});
//   if (!client) return complain(client.error());
//   auto upload = client->upload_capture("pull.h5");
//   auto job = client->submit({.spec_json = R"({"kind":"diagnose","captures":["<sha>"], ...})"});
//   auto last = client->watch(*job, [](const JobUpdate& u) { show(u); });
//   auto file = client->fetch_result(*job, "result.json");
//
// Every function may be called from any thread, several at a time. Each waits at most
// ClientOptions::timeout for the server's answer (transfers and watch: for each step of progress)
// and sends a request again after 1, 2 and 4 seconds; requests that change something carry an
// identifier by which the server knows a repeat, so nothing is done twice. Functions that return
// JSON return one object as text, already checked to be one; its keys are listed in README.md of
// this folder. Errors: unavailable (no server, no answer), bad_input, not_found, refused, no_space
// as the server says them.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/api/job_update.h"
#include "common/base/error.h"

namespace tenter::client {

struct ClientOptions {
  std::optional<int> domain;  ///< DDS domain, 0..232; none: $TENTER_DOMAIN, else 42
  std::string server;         ///< name given to tenterd --name; "": $TENTER_SERVER, else any server
  std::string
      user;  ///< letters, digits, '_', '-', '.', at most 32; "": $TENTER_USER, else the login name
  std::string name = "tenter";               ///< shown to others in the server's list of clients
  std::chrono::milliseconds timeout{10000};  ///< for connecting, and for the answer to one request
};

/// Called as bytes move; `resumed` of them were there before. Must not call the Client.
struct TransferProgress {
  std::uint64_t bytes_done = 0;  ///< includes resumed
  std::uint64_t bytes_total = 0;
  std::uint64_t bytes_resumed = 0;
  bool stored = false;  ///< an upload: all is on the server's disk; now it reads the content
};
using TransferCallback = std::function<void(const TransferProgress&)>;

struct UploadResult {
  std::string sha256;           ///< the capture's id
  bool already_stored = false;  ///< the server had it: nothing was sent
  std::uint64_t bytes_total = 0;
  std::uint64_t bytes_resumed = 0;  ///< sent by an earlier, interrupted upload
  std::string summary_json;         ///< what the server read in it: id, kind, title, frames, ...
};

struct SubmitRequest {
  std::string spec_json;  ///< job specification (schema tenter.job): kind, captures, model, options
  std::string request_id;  ///< "" makes a new one; the same id again returns the same job
  int priority = 0;        ///< -100..100, higher first
  std::vector<std::string> depends_on;  ///< job ids that must succeed first
  std::optional<double> time_limit_s;   ///< none: the server's default
  std::optional<std::uint64_t> memory_limit_bytes;
  std::optional<int> max_attempts;
};

struct SubmitResult {
  std::string job_id;
  bool repeated = false;    ///< the server had already accepted this request_id
  bool from_store = false;  ///< the same job had been done before: it is succeeded already
  std::string job_json;     ///< the job as `show_job` shows it
};

struct JobFilter {
  std::string user;    ///< "": everybody's
  std::string state;   ///< "", or one of job_state_name()
  std::string kind;    ///< "", "fit", "simulate", "diagnose"
  int limit = 100;     ///< 1..1000 jobs in one page
  std::string cursor;  ///< "" for the first page, then "next" of the page before
};

/// Stops following; the job itself goes on.
using WatchCallback = std::function<void(const JobUpdate&)>;

class Client {
 public:
  /// Joins the domain and waits until a server answers on it. An Error tells a domain with no
  /// server from a server that speaks another major version.
  static Expected<Client> connect(const ClientOptions& options);

  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  const std::string& user() const;
  int domain() const;

  // --- server
  /// {server, version, wire, epoch, uptime_s, store, jobs{queued, running, ...}, workers, captures,
  /// clients[...], limits{...}}
  Expected<std::string> server_status();

  // --- captures
  /// Sends the file unless the server has it; an interrupted upload goes on where it stopped.
  /// The server reads the whole capture before it accepts it; a bad one is bad_input with its
  /// sentence.
  Expected<UploadResult> upload_capture(const std::filesystem::path& path,
                                        const TransferCallback& progress = {},
                                        const std::stop_token& stop = {});
  /// {captures: [{id, kind, title, frames, bytes, user, created}], next}
  Expected<std::string> list_captures(int limit = 100, const std::string& cursor = "");
  Expected<std::string> show_capture(const std::string& sha256);
  Expected<std::uint64_t> download_capture(const std::string& sha256,
                                           const std::filesystem::path& destination,
                                           const TransferCallback& progress = {},
                                           const std::stop_token& stop = {});

  // --- jobs
  Expected<SubmitResult> submit(const SubmitRequest& request);
  /// {jobs: [...], total, next}, newest first
  Expected<std::string> list_jobs(const JobFilter& filter = {});
  /// One job with its specification and its history of states.
  Expected<std::string> show_job(const std::string& job_id);
  /// What the job's worker wrote to its log: {text, truncated}; the last `bytes` of it.
  Expected<std::string> job_log(const std::string& job_id, std::size_t bytes = 32768);
  /// Asks for the job to stop; the reply {job_id, state} may still say "running". Cancelling twice
  /// is no error.
  Expected<std::string> cancel(const std::string& job_id);
  /// Runs a failed or cancelled job again: {job_id, state}.
  Expected<std::string> retry(const std::string& job_id);

  /// Follows a job until it ends (or `stop`): the callback gets where it stands now and then every
  /// change, from the thread that called watch. When the server falls silent the callback gets link
  /// = lost, and connected again when it is back; the watch goes on. Returns the last update; a
  /// stopped watch returns the state it saw last.
  Expected<JobUpdate> watch(const std::string& job_id, const WatchCallback& callback,
                            const std::stop_token& stop = {});

  /// result.json, residuals.h5, ... of a succeeded job, checked against the SHA-256 that the server
  /// names, written beside the destination and renamed into place. Returns the bytes written.
  Expected<std::uint64_t> fetch_result(const std::string& job_id,
                                       const std::filesystem::path& destination,
                                       const TransferCallback& progress = {},
                                       const std::stop_token& stop = {});
  Expected<std::uint64_t> fetch_residuals(const std::string& job_id,
                                          const std::filesystem::path& destination,
                                          const TransferCallback& progress = {},
                                          const std::stop_token& stop = {});

  /// frames.h5 of a simulated scene.
  Expected<std::uint64_t> fetch_frames(const std::string& job_id,
                                       const std::filesystem::path& destination,
                                       const TransferCallback& progress = {},
                                       const std::stop_token& stop = {});

  /// One request by name with a JSON object as body, for operations this header does not wrap.
  Expected<std::string> request(const std::string& operation, const std::string& body_json);

 private:
  class Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::client
