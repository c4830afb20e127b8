// SPDX-License-Identifier: Apache-2.0
#include "common/h5/guard.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "common/h5/handle.h"

namespace tenter::h5 {

namespace {

constexpr int kSaidOk = 0;
constexpr int kSaidError = 1;
constexpr int kOutOfMemory = 2;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitMemory = false;
#else
constexpr bool kLimitMemory = true;
#endif

std::uint64_t own_address_space() {
  std::uint64_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    unsigned long long read = 0;
    if (std::fscanf(file, "%llu", &read) == 1) pages = read;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// The hard limit is `spare` above the soft one, so that the soft one's signal is the one that is
/// seen.
void limit(__rlimit_resource_t what, rlim_t value, rlim_t spare = 0) {
  rlimit now{};
  ::getrlimit(what, &now);
  const rlim_t most = now.rlim_max == RLIM_INFINITY ? value + spare : now.rlim_max;
  const rlimit wanted{std::min(value, most), std::min(value + spare, most)};
  ::setrlimit(what, &wanted);
}

/// The child's whole life. Signals go back to their defaults so that a crash is a crash; no core is
/// left.
[[noreturn]] void child(int out, std::uint64_t address_space, const GuardLimits& limits,
                        const std::function<Expected<void>()>& read) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGINT, SIGXCPU})
    ::signal(signal, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.cpu_seconds, 2);
  if (kLimitMemory) limit(RLIMIT_AS, address_space + limits.memory_bytes);
  int code = kSaidOk;
  try {
    if (const Expected<void> result = read(); !result) {
      code = kSaidError;
      std::string reply(1, static_cast<char>(result.error().kind));
      reply += result.error().message.substr(0, 4000);  // below PIPE_BUF: one write, never blocks
      if (::write(out, reply.data(), reply.size()) < 0) code = kOutOfMemory;
    }
  } catch (const std::exception&) {
    code = kOutOfMemory;
  }
  ::_exit(code);
}

struct Ending {
  int status = 0;
  bool timed_out = false;
};

/// Waits until the child closes its end of the pipe or time is up; then collects it.
Ending wait_for(pid_t pid, int in, unsigned seconds, std::string* reply) {
  using clock = std::chrono::steady_clock;
  const clock::time_point deadline = clock::now() + std::chrono::seconds(seconds);
  Ending ending;
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - clock::now()).count();
    if (left <= 0) {
      ending.timed_out = true;
      break;
    }
    pollfd waiting{in, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(left)) <= 0) continue;
    char bytes[4096];
    const ssize_t count = ::read(in, bytes, sizeof bytes);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    reply->append(bytes, static_cast<std::size_t>(count));
  }
  if (ending.timed_out) ::kill(pid, SIGKILL);
  while (::waitpid(pid, &ending.status, 0) < 0 && errno == EINTR) {
  }
  return ending;
}

}  // namespace

Expected<void> run_guarded(const std::string& path, const std::function<Expected<void>()>& read,
                           const GuardLimits& limits) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return fail(ErrorKind::internal,
                path + ": no pipe for the reading process: " + std::strerror(errno) + ".");
  const std::uint64_t address_space = own_address_space();
  pid_t pid = -1;
  {
    // no other thread is inside HDF5 while the process is copied
    const std::lock_guard lock(library_lock());
    pid = ::fork();
    if (pid == 0) {
      renew_library_lock_in_child();
      ::close(ends[0]);
      child(ends[1], address_space, limits, read);
    }
  }
  ::close(ends[1]);
  if (pid < 0) {
    ::close(ends[0]);
    return fail(ErrorKind::internal,
                path + ": the reading process could not be started: " + std::strerror(errno) + ".");
  }
  std::string reply;
  const Ending ending = wait_for(pid, ends[0], limits.wall_seconds, &reply);
  ::close(ends[0]);

  if (ending.timed_out || (WIFSIGNALED(ending.status) && WTERMSIG(ending.status) == SIGXCPU))
    return bad_input(path + ": the HDF5 library timed out while reading it; the file is damaged.");
  if (WIFSIGNALED(ending.status))
    return bad_input(path + ": the HDF5 library crashed while reading it (signal " +
                     std::to_string(WTERMSIG(ending.status)) + "); the file is damaged.");
  const int code = WEXITSTATUS(ending.status);
  if (code == kSaidOk) return {};
  if (code == kSaidError && !reply.empty())
    return fail(static_cast<ErrorKind>(reply[0]), reply.substr(1));
  return bad_input(path + ": reading it needs more memory than allowed.");
}

}  // namespace tenter::h5
