// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that the daemon's endpoints ask of the queue, the store and the workers, behind one
// door.
//
//   auto service = JobService::open(config);           // repairs, re-queues what was running,
//   reports what it found for (auto& line : (*service)->findings()) log(line);
//   (*service)->set_listener(publish);
//   (*service)->start();                               // scheduler thread and workers
//   auto done = (*service)->submit(request);           // durable when it returns
//
// All functions may be called from any thread, except open, set_listener and start: once, in that
// order. What a function acknowledges is on disk. Each costs one commit at most (a fraction of a
// millisecond on an idle disk); upload_finish reads the file once.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/store/uploads.h"
#include "server/jobs/types.h"

namespace tenter::jobs {

/// What the reader of captures says about an uploaded file.
struct CaptureSummary {
  std::string title;
  std::string kind;
  std::string summary_json;  ///< one object
};

struct ServiceConfig {
  std::filesystem::path store;   ///< folder; made if missing
  std::filesystem::path worker;  ///< the tenter-worker program
  int parallel = 0;              ///< workers at once; 0: one per core
  Quota default_quota;
  double default_time_limit_s = 3600;
  double max_time_limit_s = 7 * 24 * 3600.0;
  std::uint64_t default_memory_limit_bytes = 4ull << 30;
  std::uint64_t max_memory_limit_bytes = 64ull << 30;
  std::uint64_t max_capture_bytes = 16ull << 30;
  int max_attempts = 3;
  std::chrono::milliseconds lease{30000};
  std::chrono::milliseconds heartbeat{10000};
  std::chrono::milliseconds kill_grace{3000};  ///< between asking a worker to stop and killing it

  /// Reads an uploaded file in a limited process and says what it is, or why not; bad_input refuses
  /// the upload.
  std::function<Expected<CaptureSummary>(const std::filesystem::path&)> inspect_capture;
  /// Checks the "model" member of a specification (JSON text). Empty: only its form is checked.
  std::function<Expected<void>(std::string_view)> check_model;
  /// The same for "scene".
  std::function<Expected<void>(std::string_view)> check_scene;
  /// One line about trouble that has no caller to tell (a full disk met by the scheduler). Any
  /// thread.
  std::function<void(const std::string&)> log;
};

struct StatusNumbers {
  QueueNumbers queue;
  int workers = 0;  ///< slots
  int busy = 0;
  std::uint64_t disk_free_bytes = 0;
  double uptime_s = 0;
};

/// A result file of a succeeded job, checked against its hash.
struct StoredFile {
  std::filesystem::path path;
  std::string sha256;
  std::uint64_t size_bytes = 0;
};

struct JobLog {
  std::string text;  ///< the end of what the worker wrote to its standard error
  bool truncated = false;
};

class JobService {
 public:
  static Expected<std::unique_ptr<JobService>> open(ServiceConfig config);
  ~JobService();  ///< as stop()

  /// What was wrong and what was done about it when the store was opened; one sentence each.
  const std::vector<std::string>& findings() const;
  /// Grows by one with every start on this store; lets clients see a restart.
  std::int64_t server_epoch() const;
  /// Random, made with the store.
  const std::string& server_id() const;

  /// Called after the commit, in the order of each job's events, from the scheduler's thread only:
  /// must return soon, may call any function of JobService. Progress comes as what == "progress",
  /// at most ten times a second per job.
  void set_listener(std::function<void(const JobEvent&)> listener);

  void start();
  /// No new jobs start; running workers are killed and their jobs go back to the queue.
  void stop();

  // --- jobs
  Expected<Submitted> submit(const SubmitRequest& request);
  Expected<JobPage> list(const JobFilter& filter) const;
  Expected<JobRecord> show(JobId job) const;
  /// At once and durable, also for a running job, whose worker is stopped afterwards. Twice is no
  /// error; succeeded and failed jobs refuse.
  Expected<JobRecord> cancel(const std::string& user, JobId job);
  /// A failed or cancelled job goes back to the queue, at most ten times.
  Expected<JobRecord> retry(const std::string& user, const std::string& request_id, JobId job);
  Expected<std::vector<JobEvent>> events(JobId job, std::int64_t after_number = 0,
                                         int limit = 1000) const;
  /// result.json, residuals.h5, or frames.h5.
  Expected<StoredFile> result(JobId job);
  Expected<StoredFile> residuals(JobId job);
  Expected<StoredFile> frames(JobId job);
  Expected<JobLog> log(JobId job, std::size_t bytes = 32768) const;

  // --- captures: see uploads.h for the transfer
  Expected<UploadState> upload_open(const UploadRequest& request);
  Expected<UploadProgress> upload_chunk(const std::string& transfer, std::uint64_t index,
                                        std::string_view bytes,
                                        std::optional<std::uint32_t> crc32c = std::nullopt);
  /// All chunks are there, on disk, and are those of the client's file: the client may forget it.
  Expected<void> upload_store(const std::string& transfer, const std::string& checksums);
  /// Makes it durable, checks hash and content side by side, inserts the row. `created` false: it
  /// was there already.
  struct Committed {
    CaptureRecord capture;
    bool created = false;
  };
  Expected<Committed> upload_commit(const std::string& transfer, const std::string& sha256 = {});
  Expected<void> upload_abandon(const std::string& transfer);
  Expected<CapturePage> captures(const CaptureFilter& filter) const;
  Expected<CaptureRecord> capture(const std::string& sha256) const;
  Expected<StoredFile> capture_file(const std::string& sha256);

  // --- users
  Expected<Usage> usage(const std::string& user) const;
  Expected<void> set_quota(const std::string& user, const Quota& quota);

  Expected<StatusNumbers> status() const;
  const ServiceConfig& config() const;

 private:
  class Impl;
  explicit JobService(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenter::jobs
