// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <future>
#include <system_error>

#include "common/base/sha256.h"
#include "server/jobs/queue/queue.h"
#include "server/jobs/scheduler.h"
#include "server/jobs/spec.h"
#include "server/jobs/store/files.h"
#include "server/jobs/store/store.h"
#include "server/jobs/store/turns.h"
#include "server/jobs/worker/local_executor.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

class JobService::Impl {
 public:
  ServiceConfig config;
  FileDescriptor lock;
  std::vector<std::string> findings;
  std::unique_ptr<Store> store;
  std::unique_ptr<Uploads> uploads;
  std::unique_ptr<Queue> queue;
  std::unique_ptr<Scheduler> scheduler;
  std::unique_ptr<LocalExecutor> executor;  // dies before the scheduler that it wakes
  std::chrono::steady_clock::time_point opened = std::chrono::steady_clock::now();

  Turns turns;  // of what ends a transfer

  Expected<void> open();
  Expected<Committed> commit(const std::string& transfer, const std::string& sha256);
  Expected<StoredFile> object(const std::string& sha256, std::uint64_t size);

 private:
  Expected<void> take_lock();
  Expected<void> open_queue(const std::string& engine);
  void check_objects();
};

// --- opening

Expected<void> JobService::Impl::take_lock() {
  auto file = open_file(config.store / "lock", O_RDWR | O_CREAT);
  if (!file) return tl::unexpected(file.error());
  if (::flock(file->get(), LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorKind::refused, config.store.string() + ": another daemon is using this store");
  }
  lock = std::move(*file);
  return {};
}

Expected<void> JobService::Impl::open_queue(const std::string& engine) {
  QueueConfig settings;
  settings.file = config.store / "queue.sqlite";
  settings.engine = engine;
  settings.default_quota = config.default_quota;
  settings.default_time_limit_s = config.default_time_limit_s;
  settings.max_time_limit_s = config.max_time_limit_s;
  settings.default_memory_limit_bytes = config.default_memory_limit_bytes;
  settings.max_memory_limit_bytes = config.max_memory_limit_bytes;
  settings.max_attempts = config.max_attempts;
  settings.lease = config.lease;
  settings.result_is_sound = [this](const std::string& sha256) {
    return store->path(sha256).has_value();
  };
  auto opened_queue = Queue::open(std::move(settings));
  if (!opened_queue) return tl::unexpected(opened_queue.error());
  queue = std::move(*opened_queue);
  findings.insert(findings.end(), queue->findings().begin(), queue->findings().end());
  return {};
}

void JobService::Impl::check_objects() {
  auto troubles = queue->check_objects([this](const std::string& sha256, std::uint64_t size) {
    return store->check_present(sha256, size);
  });
  if (troubles) {
    findings.insert(findings.end(), troubles->begin(), troubles->end());
  } else {
    findings.push_back(troubles.error().message);
  }
}

Expected<void> JobService::Impl::open() {
  ::signal(SIGXFSZ,
           SIG_IGN);  // a file that may not grow is an Error of the write, not the daemon's end
  if (auto done = make_folder(config.store); !done) return done;
  std::error_code error;
  config.store = fs::canonical(config.store, error);
  if (error)
    return tl::unexpected<Error>(system_error(config.store, "opening the store", error.value()));
  if (auto done = take_lock(); !done) return done;
  const fs::path work = config.store / "work", logs = config.store / "logs";
  fs::remove_all(work, error);  // of workers that died with their daemon
  for (const auto& folder : {work, logs}) {
    if (auto done = make_folder(folder); !done) return done;
  }
  // results depend on the program too: another worker gives another engine
  auto engine = sha256_file(config.worker);
  if (!engine)
    return fail(engine.error().kind,
                config.worker.string() + ": the worker program cannot be read");

  auto opened_store = Store::open(config.store);
  if (!opened_store) return tl::unexpected(opened_store.error());
  store = std::move(*opened_store);
  auto opened_uploads = Uploads::open(config.store / "uploads");
  if (!opened_uploads) return tl::unexpected(opened_uploads.error());
  uploads = std::move(*opened_uploads);
  if (auto done = open_queue(*engine); !done) return done;
  check_objects();

  auto checkpoints = Checkpoints::open(config.store / "checkpoints", *engine);
  if (!checkpoints) return tl::unexpected(checkpoints.error());
  SchedulerConfig settings{work, logs, std::move(*checkpoints), config.heartbeat, config.log};
  scheduler = std::make_unique<Scheduler>(*queue, *store, std::move(settings));
  auto created = LocalExecutor::create(
      {config.worker, config.parallel, config.kill_grace, [this] { scheduler->wake(); }});
  if (!created) return tl::unexpected(created.error());
  executor = std::move(*created);
  return {};
}

JobService::JobService(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
JobService::~JobService() {
  stop();
}

Expected<std::unique_ptr<JobService>> JobService::open(ServiceConfig config) {
  auto impl = std::make_unique<Impl>();
  impl->config = std::move(config);
  if (auto done = impl->open(); !done) return tl::unexpected(done.error());
  return std::unique_ptr<JobService>(new JobService(std::move(impl)));
}

const std::vector<std::string>& JobService::findings() const {
  return impl_->findings;
}
std::int64_t JobService::server_epoch() const {
  return impl_->queue->server_epoch();
}
const std::string& JobService::server_id() const {
  return impl_->queue->server_id();
}
const ServiceConfig& JobService::config() const {
  return impl_->config;
}

void JobService::set_listener(std::function<void(const JobEvent&)> listener) {
  impl_->scheduler->set_listener(std::move(listener));
}
void JobService::start() {
  impl_->scheduler->start(*impl_->executor);
}
void JobService::stop() {
  impl_->scheduler->stop();
}

// --- jobs

Expected<Submitted> JobService::submit(const SubmitRequest& request) {
  auto spec = parse_spec(request.spec_json, impl_->config.check_model, impl_->config.check_scene);
  if (!spec) return tl::unexpected(spec.error());
  auto submitted = impl_->queue->submit(request, *spec);
  if (submitted && !submitted->repeated) impl_->scheduler->wake();
  return submitted;
}

Expected<JobPage> JobService::list(const JobFilter& filter) const {
  auto page = impl_->queue->list(filter);
  if (!page) return page;
  for (auto& job : page->jobs) {
    if (job.state == JobState::running) job.progress = impl_->scheduler->progress(job.id);
  }
  return page;
}

Expected<JobRecord> JobService::show(JobId id) const {
  auto job = impl_->queue->show(id);
  if (job && job->state == JobState::running) job->progress = impl_->scheduler->progress(id);
  return job;
}

Expected<JobRecord> JobService::cancel(const std::string& user, JobId job) {
  auto cancelled = impl_->queue->cancel(user, job);
  if (cancelled) impl_->scheduler->cancel(job);
  return cancelled;
}

Expected<JobRecord> JobService::retry(const std::string& user, const std::string& request_id,
                                      JobId job) {
  auto again = impl_->queue->retry(user, request_id, job);
  if (again) impl_->scheduler->wake();
  return again;
}

Expected<std::vector<JobEvent>> JobService::events(JobId job, std::int64_t after_number,
                                                   int limit) const {
  return impl_->queue->events(job, after_number, limit);
}

Expected<StoredFile> JobService::Impl::object(const std::string& sha256, std::uint64_t size) {
  auto path = store->path(sha256);
  if (!path) return tl::unexpected(path.error());
  return StoredFile{*path, sha256, size};
}

Expected<StoredFile> JobService::result(JobId job) {
  auto stored = impl_->queue->stored_result(job);
  if (!stored) return tl::unexpected(stored.error());
  return impl_->object(stored->result_sha256, stored->result_bytes);
}

Expected<StoredFile> JobService::residuals(JobId job) {
  auto stored = impl_->queue->stored_result(job);
  if (!stored) return tl::unexpected(stored.error());
  if (stored->residuals_sha256.empty()) {
    return fail(ErrorKind::not_found, "job " + job_id_text(job) + " left no residuals");
  }
  return impl_->object(stored->residuals_sha256, stored->residuals_bytes);
}

Expected<StoredFile> JobService::frames(JobId job) {
  auto stored = impl_->queue->stored_result(job);
  if (!stored) return tl::unexpected(stored.error());
  if (stored->frames_sha256.empty()) {
    return fail(ErrorKind::not_found,
                "job " + job_id_text(job) + " left no frames: only a simulated scene has them");
  }
  return impl_->object(stored->frames_sha256, stored->frames_bytes);
}

Expected<JobLog> JobService::log(JobId job, std::size_t bytes) const {
  if (auto known = impl_->queue->show(job); !known) return tl::unexpected(known.error());
  const fs::path path = impl_->scheduler->log_file(job);
  auto file = open_file(path, O_RDONLY);
  if (!file) return JobLog{};  // it has not run, or its log was removed
  const off_t size = ::lseek(file->get(), 0, SEEK_END);
  const off_t start =
      std::max<off_t>(0, size - static_cast<off_t>(std::min<std::size_t>(bytes, 1u << 20)));
  JobLog log{std::string(static_cast<std::size_t>(size - start), '\0'), start > 0};
  const ssize_t got = ::pread(file->get(), log.text.data(), log.text.size(), start);
  if (got < 0) return tl::unexpected<Error>(system_error(path, "reading", errno));
  log.text.resize(static_cast<std::size_t>(got));
  return log;
}

// --- captures

Expected<UploadState> JobService::upload_open(const UploadRequest& request) {
  const ServiceConfig& config = impl_->config;
  if (!is_user_name(request.user))
    return bad_input("'" + request.user.substr(0, 80) + "' is not a user name");
  if (request.size_bytes > config.max_capture_bytes) {
    return bad_input("a capture of " + std::to_string(request.size_bytes) +
                     " bytes is larger than the allowed " +
                     std::to_string(config.max_capture_bytes));
  }
  if (auto known = impl_->queue->capture(request.sha256)) {
    if (impl_->store->path(request.sha256)) {  // else it was damaged or lost: welcome again
      UploadState state;
      state.already_stored = true;
      state.size_bytes = known->size_bytes;
      return state;
    }
  }
  auto usage = impl_->queue->usage(request.user);
  if (!usage) return tl::unexpected(usage.error());
  const auto taken =
      usage->stored_bytes + impl_->uploads->pending_bytes(request.user, request.sha256);
  if (taken + request.size_bytes > usage->quota.max_stored_bytes) {
    return fail(ErrorKind::refused,
                "user " + request.user + " has " + std::to_string(taken) +
                    " bytes in the store; with this capture they would exceed the quota of " +
                    std::to_string(usage->quota.max_stored_bytes));
  }
  return impl_->uploads->open_transfer(request);
}

Expected<UploadProgress> JobService::upload_chunk(const std::string& transfer, std::uint64_t index,
                                                  std::string_view bytes,
                                                  std::optional<std::uint32_t> crc32c) {
  return impl_->uploads->write_chunk(transfer, index, bytes, crc32c);
}

Expected<void> JobService::upload_store(const std::string& transfer, const std::string& checksums) {
  const Turns::Turn turn(impl_->turns, transfer);
  return impl_->uploads->confirm(transfer, checksums);
}

Expected<JobService::Committed> JobService::upload_commit(const std::string& transfer,
                                                          const std::string& sha256) {
  const Turns::Turn turn(impl_->turns, transfer);
  return impl_->commit(transfer, sha256);
}

// Bytes checked and on disk, content read, object in place, row inserted, transfer dropped: in this
// order, and each step may be repeated by who asks again after a lost reply or a restart.
Expected<JobService::Committed> JobService::Impl::commit(const std::string& transfer,
                                                         const std::string& sha256) {
  const auto sealed = uploads->seal(transfer);
  if (!sealed) {
    if (sealed.error().kind != ErrorKind::not_found) return tl::unexpected(sealed.error());
    auto before = queue->committed_transfer(transfer);
    if (!before) return tl::unexpected(before.error());
    if (!*before) return tl::unexpected(sealed.error());
    auto capture = queue->capture(**before);
    if (!capture) return tl::unexpected(capture.error());
    return Committed{std::move(*capture), false};
  }
  const auto read = [this](const fs::path& path) -> Expected<CaptureSummary> {
    return config.inspect_capture ? config.inspect_capture(path) : CaptureSummary{};
  };
  const bool here = fs::exists(*sealed);  // an interrupted commit may have moved it on already
  std::future<Expected<CaptureSummary>> reading;
  if (here) reading = std::async(std::launch::async, read, *sealed);
  auto file = uploads->finish(transfer, sha256);
  auto seen = here   ? reading.get()
              : file ? store->path(file->request.sha256).and_then(read)
                     : Expected<CaptureSummary>{};
  if (!file) return tl::unexpected(file.error());  // what was read of such a file says nothing
  if (!seen) {
    if (seen.error().kind == ErrorKind::bad_input) {
      if (auto dropped = uploads->drop(transfer); !dropped) return tl::unexpected(dropped.error());
    }
    return tl::unexpected(seen.error());
  }
  const CaptureSummary& summary = *seen;
  const UploadRequest& request = file->request;
  if (!store->path(request.sha256)) {  // else by an interrupted commit, or as a result
    auto adopted = store->adopt(file->path, request.sha256);
    if (!adopted) return tl::unexpected(adopted.error());
  }
  auto added = queue->add_capture({request.sha256, summary.title, summary.kind, request.user, 0,
                                   request.size_bytes, summary.summary_json},
                                  transfer);
  if (!added) return tl::unexpected(added.error());
  if (auto dropped = uploads->drop(transfer); !dropped && config.log)
    config.log(dropped.error().message);
  return Committed{std::move(added->capture), added->created};
}

Expected<void> JobService::upload_abandon(const std::string& transfer) {
  return impl_->uploads->drop(transfer);
}

Expected<CapturePage> JobService::captures(const CaptureFilter& filter) const {
  return impl_->queue->captures(filter);
}

Expected<CaptureRecord> JobService::capture(const std::string& sha256) const {
  return impl_->queue->capture(sha256);
}

Expected<StoredFile> JobService::capture_file(const std::string& sha256) {
  auto known = impl_->queue->capture(sha256);
  if (!known) return tl::unexpected(known.error());
  return impl_->object(sha256, known->size_bytes);
}

// --- users and numbers

Expected<Usage> JobService::usage(const std::string& user) const {
  return impl_->queue->usage(user);
}

Expected<void> JobService::set_quota(const std::string& user, const Quota& quota) {
  return impl_->queue->set_quota(user, quota);
}

Expected<StatusNumbers> JobService::status() const {
  auto numbers = impl_->queue->numbers();
  if (!numbers) return tl::unexpected(numbers.error());
  StatusNumbers status;
  status.queue = *numbers;
  status.workers = impl_->executor->slots();
  status.busy = impl_->executor->busy();
  status.disk_free_bytes = impl_->store->free_bytes();
  status.uptime_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - impl_->opened).count();
  return status;
}

}  // namespace tenter::jobs
