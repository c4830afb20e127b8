// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/worker/local_executor.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

#include "server/jobs/store/files.h"
#include "server/jobs/worker/worker_process.h"
#include "server/jobs/worker/worker_protocol.h"

namespace tenter::jobs {
namespace {

using std::chrono::steady_clock;

// glibc 2.36 declares pidfd_open for C only
int open_process(pid_t pid) {
  return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
}

}  // namespace

// The thread that owns the waiting. `mutex_` guards the workers; it is not held while waiting.
class LocalExecutor::Supervisor {
 public:
  Supervisor(LocalExecutorConfig config, FileDescriptor wake)
      : config_(std::move(config)),
        wake_(std::move(wake)),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  ~Supervisor() {
    {
      const std::lock_guard lock(mutex_);
      for (auto& [claim, worker] : workers_) {
        worker.end.asked_to_stop = true;
        ::kill(-worker.pid, SIGKILL);
      }
    }
    thread_.request_stop();
    ring();
    thread_.join();
  }

  Expected<void> start(const WorkOrder& order) {
    if (auto done = make_folder(order.folder / "out"); !done) return done;
    auto file = open_file(order.folder / "order.json", O_WRONLY | O_CREAT | O_TRUNC);
    if (!file) return tl::unexpected(file.error());
    if (auto done =
            write_all(file->get(), write_order(order, ::getpid()), order.folder / "order.json");
        !done) {
      return done;
    }
    file->close();
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
      return tl::unexpected<Error>(system_error(config_.worker, "making a pipe", errno));
    }
    Worker worker;
    worker.order = order;
    worker.pipe = FileDescriptor(ends[0]);
    const FileDescriptor low_end(ends[1]);
    // above the descriptors that the worker's own take
    const FileDescriptor far_end(::fcntl(ends[1], F_DUPFD_CLOEXEC, kWorkerPipe + 1));
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);

    const std::lock_guard lock(mutex_);
    auto pid = spawn_worker(config_.worker, order, far_end.get());
    if (!pid) return tl::unexpected(pid.error());
    worker.pid = *pid;
    worker.process = FileDescriptor(open_process(worker.pid));
    if (!worker.process) {
      const int error = errno;
      ::kill(-worker.pid, SIGKILL);
      ::waitpid(worker.pid, nullptr, 0);
      return tl::unexpected<Error>(system_error(config_.worker, "watching a worker", error));
    }
    worker.deadline = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(
                                                std::chrono::duration<double>(order.time_limit_s));
    workers_[order.claim] = std::move(worker);
    ring();
    return {};
  }

  void stop(ClaimKey claim, Manner manner) {
    const std::lock_guard lock(mutex_);
    const auto found = workers_.find(claim);
    if (found == workers_.end()) return;
    Worker& worker = found->second;
    worker.end.asked_to_stop = true;
    if (manner == Manner::kill) {
      ::kill(-worker.pid, SIGKILL);
    } else if (!worker.kill_at) {
      ::kill(-worker.pid, SIGTERM);
      worker.kill_at = steady_clock::now() + config_.kill_grace;
      ring();
    }
  }

  std::vector<WorkReport> poll() {
    const std::lock_guard lock(mutex_);
    return std::exchange(reports_, {});
  }

  int slots() const { return config_.slots; }
  int busy() const {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(workers_.size());
  }

 private:
  struct Worker {
    WorkOrder order;
    pid_t pid = 0;
    FileDescriptor process;  // readable when it has ended
    FileDescriptor pipe;
    std::string buffer;
    steady_clock::time_point deadline;
    WorkerEnd end;
    std::optional<steady_clock::time_point> kill_at;
  };

  void ring() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_.get(), &one, sizeof one);
  }

  void run(const std::stop_token& stop) {
    for (;;) {
      std::vector<pollfd> waits{{wake_.get(), POLLIN, 0}};
      int timeout = -1;
      {
        const std::lock_guard lock(mutex_);
        if (stop.stop_requested() && workers_.empty()) return;
        const auto now = steady_clock::now();
        for (auto& [claim, worker] : workers_) {
          enforce_limits(worker, now);
          waits.push_back({worker.process.get(), POLLIN, 0});
          if (worker.pipe) waits.push_back({worker.pipe.get(), POLLIN, 0});
          const auto next = worker.kill_at.value_or(worker.deadline);
          const auto left =
              std::chrono::duration_cast<std::chrono::milliseconds>(next - now).count() + 1;
          const int wait = static_cast<int>(std::clamp<std::int64_t>(left, 1, 3600 * 1000));
          timeout = timeout < 0 ? wait : std::min(timeout, wait);
        }
      }
      ::poll(waits.data(), waits.size(), timeout);
      if (waits[0].revents != 0) {
        std::uint64_t count = 0;
        [[maybe_unused]] const auto got = ::read(wake_.get(), &count, sizeof count);
      }
      bool news = false;
      {
        const std::lock_guard lock(mutex_);
        for (auto it = workers_.begin(); it != workers_.end();) {
          news = listen(it->second) || news;
          if (ended(it->second)) {
            news = true;
            it = workers_.erase(it);
          } else {
            ++it;
          }
        }
      }
      if (news && config_.wake) config_.wake();
    }
  }

  void enforce_limits(Worker& worker, steady_clock::time_point now) {
    if (worker.kill_at) {
      if (now < *worker.kill_at) return;
      ::kill(-worker.pid, SIGKILL);
      worker.kill_at = now + std::chrono::seconds(1);  // until its end is seen
    } else if (now >= worker.deadline) {
      worker.end.out_of_time = true;
      ::kill(-worker.pid, SIGTERM);  // a moment to end by itself, like a cancelled one
      worker.kill_at = now + config_.kill_grace;
    }
  }

  // Takes what is in the pipe, a bounded amount: a worker that floods it must not starve the
  // others.
  bool listen(Worker& worker) {
    if (!worker.pipe) return false;
    bool news = false;
    for (int pieces = 0; pieces < 16; ++pieces) {
      char piece[4096];
      const ssize_t got = ::read(worker.pipe.get(), piece, sizeof piece);
      if (got < 0 && errno == EINTR) continue;
      if (got == 0) worker.pipe.close();
      if (got <= 0) break;
      worker.buffer.append(piece, static_cast<std::size_t>(got));
      news = take_lines(worker) || news;
    }
    return news;
  }

  bool take_lines(Worker& worker) {
    bool news = false;
    std::size_t start = 0;
    for (auto end = worker.buffer.find('\n'); end != std::string::npos;
         end = worker.buffer.find('\n', start)) {
      const auto line = read_line(std::string_view(worker.buffer).substr(start, end - start));
      start = end + 1;
      if (!line) continue;
      if (const auto* error = std::get_if<Error>(&*line)) {
        worker.end.said = *error;
        continue;
      }
      WorkReport& report = report_of(worker.order.claim);
      if (const auto* progress = std::get_if<JobProgress>(&*line)) report.progress = *progress;
      news = true;
    }
    worker.buffer.erase(0, start);
    if (worker.buffer.size() > kMaxWorkerLine) worker.buffer.clear();
    return news;
  }

  // One report per claim until the next poll.
  WorkReport& report_of(ClaimKey claim) {
    for (auto& report : reports_) {
      if (report.claim == claim) return report;
    }
    return reports_.emplace_back(WorkReport{claim, {}, {}});
  }

  bool ended(Worker& worker) {
    int status = 0;
    rusage used{};
    if (::wait4(worker.pid, &status, WNOHANG, &used) != worker.pid) return false;
    ::kill(-worker.pid, SIGKILL);  // children that it left
    while (listen(worker)) {
    }
    report_of(worker.order.claim).outcome = outcome_of(worker.order, worker.end, status, used);
    return true;
  }

  const LocalExecutorConfig config_;
  FileDescriptor wake_;
  mutable std::mutex mutex_;
  std::map<ClaimKey, Worker> workers_;
  std::vector<WorkReport> reports_;
  std::jthread thread_;
};

Expected<std::unique_ptr<LocalExecutor>> LocalExecutor::create(LocalExecutorConfig config) {
  if (::access(config.worker.c_str(), X_OK) != 0) {
    return fail(ErrorKind::not_found,
                config.worker.string() + ": the worker program is missing or not executable");
  }
  if (config.slots <= 0)
    config.slots = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  FileDescriptor wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake) return tl::unexpected<Error>(system_error(config.worker, "making an event", errno));
  auto supervisor = std::make_unique<Supervisor>(std::move(config), std::move(wake));
  return std::unique_ptr<LocalExecutor>(new LocalExecutor(std::move(supervisor)));
}

LocalExecutor::LocalExecutor(std::unique_ptr<Supervisor> supervisor)
    : supervisor_(std::move(supervisor)) {}
LocalExecutor::~LocalExecutor() = default;
Expected<void> LocalExecutor::start(const WorkOrder& order) {
  return supervisor_->start(order);
}
void LocalExecutor::stop(ClaimKey claim, Manner manner) {
  supervisor_->stop(claim, manner);
}
std::vector<WorkReport> LocalExecutor::poll() {
  return supervisor_->poll();
}
int LocalExecutor::slots() const {
  return supervisor_->slots();
}
int LocalExecutor::busy() const {
  return supervisor_->busy();
}

}  // namespace tenter::jobs
