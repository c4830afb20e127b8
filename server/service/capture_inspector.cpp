// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/capture_inspector.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/capture/file/capture_file.h"
#include "common/scene/document.h"
#include "server/jobs/types.h"

namespace tenter::service {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

namespace {

constexpr auto kTimeLimit = std::chrono::seconds(120);
constexpr std::size_t kMostOutput = 1u << 20;

// The path is the server's own business: the message speaks of the capture.
std::string without_path(std::string message, const std::string& path) {
  for (std::size_t at; (at = message.find(path)) != std::string::npos;)
    message.replace(at, path.size(), "the capture");
  return message;
}

struct Ended {
  std::string output;
  int status = 0;
  bool timed_out = false;
};

Expected<Ended> run(const std::string& program, const std::string& file) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return fail(ErrorKind::internal,
                std::string("no pipe for reading a capture: ") + std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  std::string arguments[] = {program, "--inspect-capture", file};
  char* argv[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(), nullptr};
  pid_t pid = -1;
  posix_spawnattr_t attributes;  // the daemon's threads block signals; this process should not
  posix_spawnattr_init(&attributes);
  sigset_t none;
  ::sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const int failed = ::posix_spawn(&pid, program.c_str(), &actions, &attributes, argv, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (failed != 0) {
    ::close(ends[0]);
    return fail(ErrorKind::internal,
                std::string("the process that reads captures could not be started: ") +
                    std::strerror(failed));
  }
  Ended ended;
  const auto deadline = Clock::now() + kTimeLimit;
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    ended.timed_out = left <= 0;
    if (ended.timed_out) break;
    pollfd waiting{ends[0], POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(left)) <= 0) continue;
    char bytes[16384];
    const ssize_t got = ::read(ends[0], bytes, sizeof bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    if (ended.output.size() < kMostOutput)
      ended.output.append(bytes, static_cast<std::size_t>(got));
  }
  ::close(ends[0]);
  if (ended.timed_out) ::kill(pid, SIGKILL);
  while (::waitpid(pid, &ended.status, 0) < 0 && errno == EINTR) {
  }
  return ended;
}

Expected<jobs::CaptureSummary> inspect(const std::filesystem::path& program,
                                       const std::filesystem::path& file) {
  auto ended = run(program.string(), file.string());
  if (!ended) return tl::unexpected(ended.error());
  if (ended->timed_out) return bad_input("reading the capture takes too long; the file is damaged");
  const json said = json::parse(ended->output, nullptr, false);
  if (!said.is_object())
    return bad_input("reading the capture ended without a word; the file is damaged");
  if (!said.value("ok", false)) {
    const auto kind = jobs::error_kind_from(said.value("error", std::string()));
    return fail(kind.value_or(ErrorKind::internal),
                without_path(said.value("message", std::string("the capture cannot be read")),
                             file.string()));
  }
  return jobs::CaptureSummary{said.value("title", std::string()), said.value("kind", std::string()),
                              said.value("summary", json::object()).dump()};
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitMemory = false;  // a sanitizer reserves terabytes
#else
constexpr bool kLimitMemory = true;
#endif

// What a hostile file may cost before the process ends.
void limit_this_process() {
  const auto limit = [](__rlimit_resource_t what, rlim_t value) {
    const rlimit wanted{value, value};
    ::setrlimit(what, &wanted);
  };
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, 100);
  limit(RLIMIT_FSIZE, 0);
  if (kLimitMemory) limit(RLIMIT_AS, rlim_t{16} << 30);
}

json summary_of(const capture::Capture& capture) {
  json channels = json::array();
  for (const capture::Channel& channel : capture.channels)
    channels.push_back({{"name", channel.name}, {"unit", channel.unit}});
  json summary = {
      {"frames", capture.frame_count()},           {"runs", capture.runs.size()},
      {"timed", !capture.time_s.empty()},          {"specimen", capture.specimen.name},
      {"material", capture.specimen.material},     {"protocol", capture.protocol.name},
      {"synthetic", capture.provenance.synthetic}, {"source", capture.provenance.source},
      {"licence", capture.provenance.licence},     {"channels", std::move(channels)}};
  if (capture.sheet)
    summary["sheet"] = {{"vertices", capture.sheet->vertex_count()},
                        {"triangles", capture.sheet->triangles.size()},
                        {"clips", capture.sheet->clips.size()},
                        {"cords", capture.sheet->cords.size()},
                        {"supports", capture.sheet->supports.size()}};
  return summary;
}

/// What is said of a mesh file, by how it begins; null for anything else. Whether it holds a mesh
/// is the question of the job that uses it.
json mesh_said(const std::string& file) {
  std::string beginning(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(stream.gcount()));
  const std::string format(scene::mesh_format(beginning));
  if (format.empty()) return {};
  return {{"ok", true}, {"kind", "mesh"}, {"title", "mesh"}, {"summary", {{"format", format}}}};
}

}  // namespace

std::function<Expected<jobs::CaptureSummary>(const std::filesystem::path&)> capture_inspector(
    std::filesystem::path program) {
  return [program = std::move(program)](const std::filesystem::path& file) {
    return inspect(program, file);
  };
}

int inspect_main(const std::string& file) {
  limit_this_process();
  if (const json mesh = mesh_said(file); !mesh.is_null()) {
    const std::string line = mesh.dump();
    std::fwrite(line.data(), 1, line.size(), stdout);
    return 0;
  }
  json said;
  const auto capture = capture::read_capture(file);
  if (capture)
    said = {{"ok", true},
            {"kind", capture->kind},
            {"title", capture->title},
            {"summary", summary_of(*capture)}};
  else
    said = {{"ok", false},
            {"error", jobs::name_of(capture.error().kind)},
            {"message", capture.error().message}};
  const std::string line = said.dump(-1, ' ', false, json::error_handler_t::replace);
  std::fwrite(line.data(), 1, line.size(), stdout);
  return capture ? 0 : static_cast<int>(capture.error().kind);
}

}  // namespace tenter::service
