// SPDX-License-Identifier: GPL-3.0-or-later
// The daemon: parses, opens the store, joins the domain, waits for a signal, stops.
#include <fcntl.h>
#include <pthread.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "common/model/document.h"
#include "common/scene/document.h"
#include "server/service/capture_inspector.h"
#include "server/service/daemon_config.h"
#include "server/service/service.h"

namespace {

using tenter::Error;
using tenter::Expected;
namespace jobs = tenter::jobs;
namespace service = tenter::service;
namespace fs = std::filesystem;

constexpr char kVersion[] = TENTER_VERSION;

struct Arguments {
  service::DaemonConfig config;
  std::string store;
  std::string config_file;
  std::string worker;
  std::string ready_file;
  std::string inspect;
  int domain = -1;
  int workers = 0;
  int ready_fd = -1;
  std::string name;
  std::vector<std::string> interfaces;
  std::string log_level;
};

fs::path own_program() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error);
}

std::string default_store() {
  if (const char* given = std::getenv("TENTER_STORE"); given && *given) return given;
  if (::geteuid() == 0) return "/var/lib/tenter";
  if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data)
    return std::string(data) + "/tenter";
  const char* home = std::getenv("HOME");
  return std::string(home && *home ? home : ".") + "/.local/share/tenter";
}

void describe(CLI::App& app, Arguments& arguments) {
  app.description(
      "tenterd, the Tenter daemon: keeps the queue and the store, runs the jobs, answers over "
      "DDS.");
  app.set_version_flag("--version", std::string("tenterd ") + kVersion);
  app.add_option(
      "--store", arguments.store,
      "Folder of the queue, the captures and the results "
      "[$TENTER_STORE, else /var/lib/tenter for root, ~/.local/share/tenter for others]");
  app.add_option("--domain", arguments.domain, "DDS domain, 0 to 232 [$TENTER_DOMAIN, else 42]")
      ->check(CLI::Range(0, 232));
  app.add_option("--name", arguments.name,
                 "What clients call this server when there are several in a domain");
  app.add_option("--workers", arguments.workers, "Jobs at a time [one for each core]")
      ->check(CLI::Range(1, 1024));
  app.add_option("--interface", arguments.interfaces,
                 "Address to be reached at, repeatable [127.0.0.1]; others than "
                 "loopback need DDS Security, see common/wire/README.md");
  app.add_option("--worker", arguments.worker,
                 "The program that runs one job [tenter-worker beside tenterd]");
  app.add_option("--config", arguments.config_file,
                 "JSON file with the same and more; options win over it");
  app.add_option("--ready-file", arguments.ready_file,
                 "Writes this file, one line of JSON, when requests are answered");
  app.add_option("--ready-fd", arguments.ready_fd,
                 "Writes the same line to this descriptor and closes it");
  app.add_option("--log-level", arguments.log_level,
                 "trace, debug, info, warning, error or off [info]");
  app.add_option("--inspect-capture", arguments.inspect)->group("");
  app.footer(
      "Runs in the foreground and logs to standard error. SIGTERM or SIGINT stops it: running jobs "
      "go\n"
      "back to the queue.\n"
      "Exit codes: 0 stopped by a signal, 1 defect, 2 bad option or configuration, 3 no such\n"
      "configuration file, 4 the store is used by another daemon, 5 the DDS domain cannot be "
      "joined,\n"
      "6 the disk is full.");
}

Expected<void> complete(Arguments& arguments) {
  auto& config = arguments.config;
  if (!arguments.config_file.empty())
    if (auto read = service::read_daemon_config(arguments.config_file, config); !read) return read;
  if (arguments.domain >= 0) config.domain = arguments.domain;
  auto domain = tenter::wire::domain_or_default(config.domain);
  if (!domain) return tl::unexpected(domain.error());
  config.domain = *domain;
  if (!arguments.name.empty()) config.name = arguments.name;
  if (!arguments.interfaces.empty()) config.interfaces = arguments.interfaces;
  if (arguments.workers > 0) config.jobs.parallel = arguments.workers;
  if (!arguments.log_level.empty()) config.log_level = arguments.log_level;
  config.jobs.store = arguments.store.empty() ? default_store() : arguments.store;
  config.jobs.worker = arguments.worker.empty() ? own_program().parent_path() / "tenter-worker"
                                                : fs::path(arguments.worker);
  config.jobs.inspect_capture = service::capture_inspector(own_program());
  config.jobs.check_model = [](std::string_view text) -> Expected<void> {
    auto model = tenter::model::parse_model(text, "model");
    if (!model) return tl::unexpected(model.error());
    return {};
  };
  config.jobs.check_scene = [](std::string_view text) -> Expected<void> {
    auto scene = tenter::scene::parse_scene(text, "scene");
    if (!scene) return tl::unexpected(scene.error());
    return {};
  };
  return {};
}

bool set_up_log(const std::string& level) {
  auto logger = spdlog::stderr_logger_mt("tenterd");
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %l %v");
  const auto value = spdlog::level::from_str(level);
  logger->set_level(value);
  logger->flush_on(spdlog::level::trace);
  spdlog::set_default_logger(logger);
  return value != spdlog::level::off || level == "off";
}

void log(service::Level level, const std::string& line) {
  switch (level) {
    case service::Level::info:
      return spdlog::info("{}", line);
    case service::Level::warning:
      return spdlog::warn("{}", line);
    case service::Level::error:
      return spdlog::error("{}", line);
  }
}

Expected<void> say_ready(const Arguments& arguments) {
  const std::string line = "{\"ready\":true,\"process\":" + std::to_string(::getpid()) +
                           ",\"domain\":" + std::to_string(*arguments.config.domain) + "}\n";
  if (!arguments.ready_file.empty()) {
    const std::string partial = arguments.ready_file + ".part";
    std::ofstream(partial) << line;
    std::error_code error;
    fs::rename(partial, arguments.ready_file, error);
    if (error)
      return tenter::bad_input(arguments.ready_file + ": cannot be written: " + error.message());
  }
  if (arguments.ready_fd >= 0) {
    const bool written =
        ::write(arguments.ready_fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
    ::close(arguments.ready_fd);
    if (!written)
      return tenter::bad_input("--ready-fd " + std::to_string(arguments.ready_fd) +
                               ": cannot be written");
  }
  return {};
}

// The signals are blocked in all threads and taken here; a second one ends the process at once.
int wait_for_signal(const sigset_t& signals) {
  int signal = 0;
  while (::sigwait(&signals, &signal) != 0) {
  }
  ::pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  return signal;
}

Expected<void> run(Arguments& arguments, const sigset_t& signals) {
  auto& config = arguments.config;
  config.jobs.log = [](const std::string& line) { spdlog::warn("{}", line); };
  tenter::wire::set_wire_log(
      [](tenter::wire::LogLevel, const std::string& line) { spdlog::debug("dds: {}", line); });
  auto queue = jobs::JobService::open(config.jobs);
  if (!queue) return tl::unexpected(queue.error());
  for (const std::string& finding : (*queue)->findings()) spdlog::warn("{}", finding);
  auto face = service::Service::start({.domain = *config.domain,
                                       .name = config.name,
                                       .software = kVersion,
                                       .interfaces = config.interfaces,
                                       .log = log},
                                      **queue);
  if (!face) return tl::unexpected(face.error());
  (*queue)->start();
  if (auto said = say_ready(arguments); !said) return said;
  spdlog::info("tenterd {} serves {} in DDS domain {}", kVersion, config.jobs.store.string(),
               *config.domain);
  const int signal = wait_for_signal(signals);
  spdlog::info("stopping on signal {}", signal);
  (*queue)->stop();
  face->reset();
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app;
  describe(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    return app.exit(problem) == 0 ? 0 : static_cast<int>(tenter::ErrorKind::bad_input);
  }
  if (!arguments.inspect.empty()) return service::inspect_main(arguments.inspect);

  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::sigaddset(&signals, SIGINT);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGPIPE, SIG_IGN);

  auto done = complete(arguments);
  if (done && !set_up_log(arguments.config.log_level))
    done = tenter::bad_input("the log level '" + arguments.config.log_level + "' is not known");
  if (done) done = run(arguments, signals);
  if (done) return 0;
  std::fprintf(stderr, "tenterd: %s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}
