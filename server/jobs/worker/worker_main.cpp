// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/worker/worker_main.h"

#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <new>
#include <thread>

#include "server/jobs/store/files.h"
#include "server/jobs/worker/worker_protocol.h"

namespace tenter::jobs {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // their shadow memory is far above any limit
#else
constexpr bool kSanitized = false;
#endif

class Reporter {
 public:
  void say(const WorkerLine& line) {
    const std::lock_guard lock(mutex_);
    write(line);
  }
  void progress(const JobProgress& progress) {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    if (progress.stage == stage_ && now < next_) return;
    stage_ = progress.stage;
    next_ = now + std::chrono::milliseconds(100);
    write(progress);
  }

 private:
  // a closed pipe means that the daemon is gone, and then so is this process in a moment
  void write(const WorkerLine& line) {
    [[maybe_unused]] auto done = write_all(kWorkerPipe, write_line(line), "the daemon's pipe");
  }
  std::mutex mutex_;
  std::string stage_;
  std::chrono::steady_clock::time_point next_;
};

void limit(const WorkOrder& order) {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  if (!kSanitized && order.memory_limit_bytes > 0) {
    // private writable memory: unlike RLIMIT_AS it does not count what libraries reserve and never
    // touch
    const rlimit memory{order.memory_limit_bytes, order.memory_limit_bytes};
    ::setrlimit(RLIMIT_DATA, &memory);
  }
  ::setpriority(PRIO_PROCESS, 0, 5);                 // answers to users before fits
  std::ofstream("/proc/self/oom_score_adj") << 500;  // and the daemon survives a full memory
}

bool die_with(int parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  return ::getppid() == parent;  // else it died before the line above
}

// Waits for SIGTERM in a thread of its own; SIGUSR1 from finish() ends the wait.
class TerminationWatch {
 public:
  TerminationWatch() {
    ::sigemptyset(&signals_);
    for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) ::sigaddset(&signals_, signal);
    ::pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    thread_ = std::thread([this] {
      int signal = 0;
      while (::sigwait(&signals_, &signal) == 0) {
        if (signal == SIGUSR1) return;
        stop_.request_stop();
      }
    });
  }
  ~TerminationWatch() {
    ::pthread_kill(thread_.native_handle(), SIGUSR1);
    thread_.join();
  }
  std::stop_token token() const { return stop_.get_token(); }

 private:
  sigset_t signals_{};
  std::stop_source stop_;
  std::thread thread_;
};

std::jthread start_heartbeat(Reporter& reporter, std::chrono::milliseconds every) {
  return std::jthread([&reporter, every](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    do {
      reporter.say(Heartbeat{});
      never.wait_for(lock, stop, every, [] { return false; });
    } while (!stop.stop_requested());
  });
}

int run_guarded(const JobInput& input, const JobFunction& run, Reporter& reporter,
                const std::stop_token& stop) {
  try {
    auto done = run(
        input, [&reporter](const JobProgress& p) { reporter.progress(p); }, stop);
    if (done) return kWorkerFinished;
    if (done.error().kind == ErrorKind::cancelled && stop.stop_requested()) return kWorkerCancelled;
    reporter.say(done.error());
  } catch (const std::bad_alloc&) {
    return kWorkerOutOfMemory;
  } catch (const std::exception& trouble) {
    reporter.say(Error{ErrorKind::internal,
                       std::string("the worker met an unexpected error: ") + trouble.what()});
  }
  return kWorkerFailed;
}

}  // namespace

int worker_main(int argc, char** argv, const JobFunction& run) {
  if (argc != 2) {
    std::fprintf(
        stderr,
        "usage: %s ORDER_FILE\nRuns one job for tenterd; not meant to be started by hand.\n",
        argv[0]);
    return kWorkerBadOrder;
  }
  auto received = read_order(argv[1]);
  if (!received) {
    std::fprintf(stderr, "%s\n", received.error().message.c_str());
    return kWorkerBadOrder;
  }
  const WorkOrder& order = received->order;
  if (!die_with(received->parent)) return kWorkerCancelled;
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a too large file is an Error of the write
  limit(order);

  const TerminationWatch termination;
  Reporter reporter;
  const std::jthread heartbeat = start_heartbeat(reporter, order.heartbeat);
  JobInput input{order.spec_json, order.captures, order.folder / "out", order.checkpoints};
  return run_guarded(input, run, reporter, termination.token());
}

}  // namespace tenter::jobs
