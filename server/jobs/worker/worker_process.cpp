// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/worker/worker_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/store/files.h"
#include "server/jobs/worker/worker_protocol.h"

extern char** environ;

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

Expected<pid_t> spawn_worker(const fs::path& program, const WorkOrder& order, int pipe_end) {
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
  environment.reserve(variables.size() + 1);
  for (auto& variable : variables) environment.push_back(variable.data());
  environment.push_back(nullptr);
  pid_t pid = 0;
  const int error = ::posix_spawn(&pid, name.c_str(), &plan.files, &plan.attributes, arguments,
                                  environment.data());
  if (error != 0) return tl::unexpected<Error>(system_error(program, "starting a worker", error));
  return pid;
}

namespace {

std::string signal_words(int signal) {
  return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
}

}  // namespace

Outcome outcome_of(const WorkOrder& order, const WorkerEnd& end, int status, const rusage& used) {
  const auto out_of_memory = [&] {
    return Outcome{
        Ending::out_of_memory,
        {ErrorKind::job_failed, "the job ran out of memory: its limit is " +
                                    std::to_string(order.memory_limit_bytes >> 20) + " MiB"}};
  };
  if (WIFEXITED(status) && WEXITSTATUS(status) == kWorkerFinished) return {Ending::finished, {}};
  if (end.asked_to_stop)
    return {Ending::cancelled, {ErrorKind::cancelled, "the worker was stopped"}};
  if (end.out_of_time) {
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
        if (end.said) return {Ending::failed, *end.said};
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

}  // namespace tenter::jobs
