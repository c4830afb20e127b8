// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/local_executor.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
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

#include "server/jobs/files.h"
#include "server/jobs/worker_protocol.h"

extern char** environ;

namespace tenter::jobs {
namespace {

using std::chrono::steady_clock;
namespace fs = std::filesystem;

struct Worker {
  WorkOrder order;
  pid_t pid = 0;
  FileDescriptor process;  // readable when it has ended
  FileDescriptor pipe;
  std::string buffer;
  std::optional<Error> said;  // its own error line
  steady_clock::time_point deadline;
  bool asked_to_stop = false;
  bool out_of_time = false;
  std::optional<steady_clock::time_point> kill_at;
};

// The daemon's environment, with numerics on one thread and in one language: the same bytes on
// every machine.
std::vector<std::string> worker_environment() {
  static constexpr std::string_view kOwn[] = {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1",
                                              "LC_ALL=C.UTF-8"};
  std::vector<std::string> variables;
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view text(*entry);
    const auto name = text.substr(0, text.find('='));
    const bool ours = std::any_of(std::begin(kOwn), std::end(kOwn),
                                  [&](auto own) { return own.substr(0, own.find('=')) == name; });
    if (!ours) variables.emplace_back(text);
  }
  variables.insert(variables.end(), std::begin(kOwn), std::end(kOwn));
  return variables;
}

// File actions and attributes of posix_spawn, freed on leaving.
struct SpawnPlan {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  SpawnPlan() {
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
  }
  ~SpawnPlan() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
};

Expected<pid_t> spawn(const fs::path& program, const WorkOrder& order, int pipe_end) {
  SpawnPlan plan;
  ::posix_spawn_file_actions_addopen(&plan.files, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&plan.files, 1, order.log.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0640);
  ::posix_spawn_file_actions_adddup2(&plan.files, 1, 2);
  ::posix_spawn_file_actions_adddup2(&plan.files, pipe_end, kWorkerPipe);
  ::posix_spawn_file_actions_addclosefrom_np(&plan.files, kWorkerPipe + 1);
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&plan.attributes, &none);
  ::posix_spawnattr_setsigdefault(&plan.attributes, &all);
  ::posix_spawnattr_setpgroup(&plan.attributes, 0);
  ::posix_spawnattr_setflags(
      &plan.attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::string name = program.string(), order_file = (order.folder / "order.json").string();
  char* arguments[] = {name.data(), order_file.data(), nullptr};
  std::vector<std::string> variables = worker_environment();
  std::vector<char*> environment;
  for (auto& variable : variables) environment.push_back(variable.data());
  environment.push_back(nullptr);
  pid_t pid = 0;
  const int error = ::posix_spawn(&pid, name.c_str(), &plan.files, &plan.attributes, arguments,
                                  environment.data());
  if (error != 0) return tl::unexpected<Error>(system_error(program, "starting a worker", error));
  return pid;
}

// glibc 2.36 declares pidfd_open for C only
int open_process(pid_t pid) {
  return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
}

std::string signal_words(int signal) {
  return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
}

Outcome outcome_of(const Worker& worker, int status, const rusage& used) {
  const auto& order = worker.order;
  const auto out_of_memory = [&] {
    return Outcome{
        Ending::out_of_memory,
        {ErrorKind::job_failed, "the job ran out of memory: its limit is " +
                                    std::to_string(order.memory_limit_bytes >> 20) + " MiB"}};
  };
  if (WIFEXITED(status) && WEXITSTATUS(status) == kWorkerFinished) return {Ending::finished, {}};
  if (worker.asked_to_stop)
    return {Ending::cancelled, {ErrorKind::cancelled, "the worker was stopped"}};
  if (worker.out_of_time) {
    char limit[32];
    std::snprintf(limit, sizeof limit, "%g", order.time_limit_s);
    return {Ending::out_of_time,
            {ErrorKind::job_failed,
             "the job ran out of time: its limit is " + std::string(limit) + " s"}};
  }
  if (WIFEXITED(status)) {
    switch (WEXITSTATUS(status)) {
      case kWorkerOutOfMemory:
        return out_of_memory();
      case kWorkerFailed:
        if (worker.said) return {Ending::failed, *worker.said};
        break;
      case kWorkerCancelled:
        return {Ending::crashed, {ErrorKind::job_failed, "its worker was stopped from outside"}};
      default:
        break;
    }
    return {Ending::crashed,
            {ErrorKind::job_failed,
             "its worker ended with exit code " + std::to_string(WEXITSTATUS(status))}};
  }
  const int signal = WTERMSIG(status);
  // C libraries abort or fault when an allocation is refused; the high-water mark tells
  const auto peak = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
  if (signal != SIGKILL && peak > order.memory_limit_bytes / 10 * 9) return out_of_memory();
  std::string words = "its worker ";
  words += signal == SIGKILL ? "was killed by " : "crashed with ";
  words += signal_words(signal);
  if (signal == SIGKILL) words += ", by the system for lack of memory or by somebody";
  return {Ending::crashed, {ErrorKind::job_failed, words}};
}

}  // namespace

// The thread that owns the waiting. `mutex_` guards the workers; it is not held while waiting.
class LocalExecutor::Supervisor {
 public:
  Supervisor(LocalExecutorConfig config, FileDescriptor wake)
      : config_(std::move(config)),
        wake_(std::move(wake)),
        thread_([this](std::stop_token stop) { run(stop); }) {}

  ~Supervisor() {
    {
      const std::lock_guard lock(mutex_);
      for (auto& [claim, worker] : workers_) {
        worker.asked_to_stop = true;
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
    auto pid = spawn(config_.worker, order, far_end.get());
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
    worker.asked_to_stop = true;
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
  void ring() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_.get(), &one, sizeof one);
  }

  void run(std::stop_token stop) {
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
      worker.out_of_time = true;
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
        worker.said = *error;
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
    report_of(worker.order.claim).outcome = outcome_of(worker, status, used);
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
