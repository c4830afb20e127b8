// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/scheduler.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include "server/jobs/store/files.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

namespace {
constexpr std::chrono::milliseconds kTryAgain{1000};
constexpr std::uintmax_t kKeepLogBytes = 4u << 20;

// A refused write is an answer (the claim is another's); everything else may succeed later.
bool is_answer(const Error& error) {
  return error.kind == ErrorKind::refused || error.kind == ErrorKind::not_found;
}
}  // namespace

Scheduler::Scheduler(Queue& queue, Store& store, SchedulerConfig config)
    : queue_(queue), store_(store), config_(std::move(config)), checkpoints_(config_.checkpoints) {}

Scheduler::~Scheduler() {
  stop();
}

void Scheduler::start(Executor& executor) {
  executor_ = &executor;
  thread_ = std::thread([this] { run(); });
}

void Scheduler::stop() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Scheduler::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  wake_.notify_one();
}

void Scheduler::run() {
  for (;;) {
    try_again_ = false;
    hear(executor_->poll());
    write_settlements();
    expire();
    fill_slots();
    tell();
    const auto pause = sleep_time();
    std::unique_lock lock(mutex_);
    const auto ready = [this] { return woken_ || stopping_; };
    if (pause) {
      wake_.wait_for(lock, *pause, ready);
    } else {
      wake_.wait(lock, ready);
    }
    woken_ = false;
    if (stopping_) break;
  }
  std::vector<ClaimKey> left;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [claim, live] : live_) left.push_back(claim);
  }
  for (const ClaimKey claim : left) {
    executor_->stop(claim, Executor::Manner::kill);
    auto done = queue_.release(claim, "the daemon was stopped while it ran");
    if (!done && !is_answer(done.error())) trouble("giving a job back", done.error());
    forget(claim);
  }
  tell();
}

void Scheduler::hear(const std::vector<WorkReport>& reports) {
  for (const auto& report : reports) {
    if (report.outcome) {
      settle(report.claim, *report.outcome);
    } else {
      hear_progress(report);
    }
  }
}

void Scheduler::hear_progress(const WorkReport& report) {
  const auto now = clock_.monotonic_ms();
  bool renew = false;
  {
    const std::lock_guard lock(mutex_);
    const auto found = live_.find(report.claim);
    if (found == live_.end()) return;  // a claim that is no longer wanted
    Live& live = found->second;
    if (report.progress) {
      live.progress = report.progress;
      JobEvent event = live.last;
      event.what = "progress";
      event.message.clear();
      event.time_ms = clock_.wall_ms();
      event.progress = report.progress;
      progress_events_.push_back(std::move(event));
    }
    renew = now - live.renewed_ms >= config_.heartbeat.count() / 2;
    if (renew) live.renewed_ms = now;
  }
  if (!renew) return;
  auto done = queue_.heartbeat(report.claim);
  if (done) return;
  if (is_answer(done.error())) {
    executor_->stop(report.claim, Executor::Manner::ask);
  } else {
    trouble("renewing a lease", done.error());
  }
}

// Result files become objects first, then one transaction names them: a kill between leaves objects
// without a row, which the next run of the job finds in place.
Expected<StoredResult> Scheduler::ingest(const ClaimKey& claim) {
  StoredResult result;
  const fs::path out = folder_of(claim) / "out";
  const auto take = [&](const char* name, std::string& sha256,
                        std::uint64_t& size) -> Expected<void> {
    auto stamp = stamp_of(out / name);
    if (!stamp) return tl::unexpected(stamp.error());
    size = stamp->size;
    auto adopted = store_.adopt(out / name);
    if (!adopted) return tl::unexpected(adopted.error());
    sha256 = *adopted;
    return {};
  };
  if (!fs::exists(out / "result.json")) {
    return fail(ErrorKind::internal, "the worker ended well but left no result.json");
  }
  if (auto done = take("result.json", result.result_sha256, result.result_bytes); !done) {
    return tl::unexpected(done.error());
  }
  if (fs::exists(out / "residuals.h5")) {
    if (auto done = take("residuals.h5", result.residuals_sha256, result.residuals_bytes); !done) {
      return tl::unexpected(done.error());
    }
  }
  if (fs::exists(out / "frames.h5")) {
    if (auto done = take("frames.h5", result.frames_sha256, result.frames_bytes); !done) {
      return tl::unexpected(done.error());
    }
  }
  return result;
}

void Scheduler::settle(ClaimKey claim, const Outcome& outcome) {
  {
    const std::lock_guard lock(mutex_);
    if (!live_.contains(claim)) {
      std::error_code ignored;
      fs::remove_all(folder_of(claim), ignored);
      return;  // cancelled or expired before: the row has moved on
    }
  }
  Settlement settlement{claim, {}, false};
  switch (outcome.ending) {
    case Ending::finished: {
      auto result = ingest(claim);
      if (result) {
        settlement.write = [this, claim, stored = *result] {
          return queue_.complete(claim, stored);
        };
        settlement.succeeded = true;
        break;
      }
      Error error = result.error();
      if (error.kind == ErrorKind::no_space) {
        error.message = "the result could not be kept, the store's disk is full: " + error.message;
      }
      settlement.write = [this, claim, error] { return queue_.fail(claim, error); };
      break;
    }
    case Ending::failed:
    case Ending::out_of_memory:
    case Ending::out_of_time:
      settlement.write = [this, claim, error = outcome.error] { return queue_.fail(claim, error); };
      break;
    case Ending::crashed:
    case Ending::cancelled:
      settlement.write = [this, claim, how = outcome.error.message] {
        return queue_.worker_died(claim, how);
      };
      break;
  }
  unsettled_.push_back(std::move(settlement));
}

void Scheduler::write_settlements() {
  std::vector<Settlement> later;
  for (auto& settlement : unsettled_) {
    auto done = settlement.write();
    if (done || is_answer(done.error())) {
      tidy_checkpoints(settlement.claim, done && settlement.succeeded);
      forget(settlement.claim);
    } else {
      trouble("recording the end of job " + job_id_text(settlement.claim.job), done.error());
      later.push_back(std::move(settlement));
    }
  }
  unsettled_ = std::move(later);
}

void Scheduler::expire() {
  auto expired = queue_.expire();
  if (!expired) return trouble("expiring leases", expired.error());
  for (const ClaimKey claim : *expired) {
    executor_->stop(claim, Executor::Manner::kill);
    forget(claim);
  }
}

Expected<WorkOrder> Scheduler::order_for(const JobRecord& job) {
  WorkOrder order;
  order.claim = {job.id, job.epoch};
  order.spec_json = job.spec_json;
  for (const auto& sha256 : job.captures) {
    auto path = store_.path(sha256);
    if (!path) return tl::unexpected(path.error());
    order.captures.emplace_back(sha256, *path);
  }
  order.folder = folder_of(order.claim);
  order.checkpoints = checkpoints_.of(job.spec_sha256);
  order.log = log_file(job.id);
  order.time_limit_s = job.time_limit_s;
  order.memory_limit_bytes = job.memory_limit_bytes;
  order.heartbeat = config_.heartbeat;
  std::error_code ignored;
  const bool long_log = fs::file_size(order.log, ignored) > kKeepLogBytes && !ignored;
  std::ofstream(order.log, long_log ? std::ios::trunc : std::ios::app)
      << "--- attempt " << job.attempt << "\n";
  return order;
}

void Scheduler::fill_slots() {
  if (!unsettled_.empty()) return;  // what cannot be recorded now should not grow
  while (executor_->busy() < executor_->slots()) {
    auto claimed = queue_.claim();
    if (!claimed) return trouble("claiming a job", claimed.error());
    if (!*claimed) return;
    const JobRecord& job = **claimed;
    const ClaimKey claim{job.id, job.epoch};
    {
      const std::lock_guard lock(mutex_);
      JobEvent frame{job.id,      job.revision, "", "",       job.state,
                     job.attempt, job.epoch,    0,  job.user, {}};
      live_[claim] = Live{{}, clock_.monotonic_ms(), std::move(frame), job.spec_sha256};
    }
    auto order = order_for(job);
    auto started = order ? executor_->start(*order) : tl::unexpected(order.error());
    if (!started) {
      unsettled_.push_back(
          {claim, [this, claim, error = started.error()] { return queue_.fail(claim, error); },
           false});
      write_settlements();
      if (!unsettled_.empty()) return;
      continue;
    }
    // a user may have cancelled between claim and start, when there was no worker to stop
    auto now = queue_.show(job.id);
    if (now && now->epoch != claim.epoch) executor_->stop(claim, Executor::Manner::ask);
  }
}

void Scheduler::tell() {
  auto events = queue_.take_events();
  auto progress = std::exchange(progress_events_, {});
  if (!listener_) return;
  // progress first: it was said before what this pass committed
  for (const auto& event : progress) listener_(event);
  for (const auto& event : events) listener_(event);
}

std::optional<std::chrono::milliseconds> Scheduler::sleep_time() {
  if (try_again_ || !unsettled_.empty()) return kTryAgain;
  {
    const std::lock_guard lock(mutex_);
    if (live_.empty()) return std::nullopt;
  }
  auto next = queue_.next_expiry_ms();
  if (!next || !*next) return kTryAgain;
  return std::chrono::milliseconds(std::max<std::int64_t>(1, **next - clock_.monotonic_ms() + 1));
}

void Scheduler::cancel(JobId job) {
  std::vector<ClaimKey> claims;
  {
    const std::lock_guard lock(mutex_);
    for (auto it = live_.begin(); it != live_.end();) {
      if (it->first.job == job) {
        claims.push_back(it->first);
        it = live_.erase(it);
      } else {
        ++it;
      }
    }
  }
  if (executor_) {
    for (const ClaimKey claim : claims) executor_->stop(claim, Executor::Manner::ask);
  }
  wake();
}

std::optional<JobProgress> Scheduler::progress(JobId job) const {
  const std::lock_guard lock(mutex_);
  for (auto it = live_.lower_bound({job, 0}); it != live_.end() && it->first.job == job; ++it) {
    if (it->second.progress) return it->second.progress;
  }
  return std::nullopt;
}

fs::path Scheduler::folder_of(ClaimKey claim) const {
  return config_.work / (job_id_text(claim.job) + "-" + std::to_string(claim.epoch));
}

fs::path Scheduler::log_file(JobId job) const {
  return config_.logs / (job_id_text(job) + ".log");
}

void Scheduler::forget(ClaimKey claim) {
  std::error_code ignored;
  fs::remove_all(folder_of(claim), ignored);
  const std::lock_guard lock(mutex_);
  live_.erase(claim);
}

void Scheduler::tidy_checkpoints(ClaimKey claim, bool succeeded) {
  std::set<std::string> running;
  std::string ended;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, live] : live_) {
      if (key == claim)
        ended = live.spec_sha256;
      else
        running.insert(live.spec_sha256);
    }
  }
  if (succeeded) checkpoints_.drop(ended);
  checkpoints_.prune(running);
}

void Scheduler::trouble(const std::string& doing, const Error& error) {
  try_again_ = true;
  const std::string line = doing + ": " + error.message;
  if (line == last_trouble_) return;
  last_trouble_ = line;
  if (config_.log) config_.log(line);
}

}  // namespace tenter::jobs
