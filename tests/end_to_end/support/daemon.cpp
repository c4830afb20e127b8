// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/end_to_end/support/daemon.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "common/model/presets.h"

namespace tenter::test {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  std::string name = (fs::temp_directory_path() / "tenter-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) std::abort();
  path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

namespace {

std::string unique_name() {
  static std::atomic<int> count{0};
  return "test-" + std::to_string(::getpid()) + '-' + std::to_string(++count);
}

}  // namespace

Daemon::Daemon(DaemonOptions options)
    : options_(std::move(options)), name_(options_.name.empty() ? unique_name() : options_.name) {
  ::setenv("TENTER_SERVER", name_.c_str(), 1);
  if (options_.start) start();
}

Daemon::~Daemon() {
  if (running()) kill();
  ::unsetenv("TENTER_SERVER");
  if (::testing::Test::HasFailure())
    std::fprintf(stderr, "--- tenterd said:\n%s---\n", log().c_str());
}

void Daemon::start() {
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  ::fcntl(ready[0], F_SETFD, FD_CLOEXEC);
  std::vector<std::string> words = {TENTER_TENTERD,
                                    "--store",
                                    store().string(),
                                    "--domain",
                                    std::to_string(domain()),
                                    "--workers",
                                    std::to_string(options_.workers),
                                    "--worker",
                                    options_.worker.empty() ? TENTER_FAKE_WORKER : options_.worker,
                                    "--name",
                                    name_,
                                    "--ready-fd",
                                    std::to_string(ready[1])};
  words.insert(words.end(), options_.arguments.begin(), options_.arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> added = options_.environment;
  std::vector<char*> environment;
  environment.reserve(added.size() + 1);
  for (std::string& one : added) environment.push_back(one.data());
  for (char** one = environ; *one != nullptr; ++one) environment.push_back(*one);
  environment.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const std::string log_file = (folder_.path() / "tenterd.log").string();
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_file.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0644);
  const int failed =
      ::posix_spawn(&pid_, TENTER_TENTERD, &actions, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(ready[1]);
  ASSERT_EQ(failed, 0) << "cannot start " << TENTER_TENTERD;

  pollfd waiting{ready[0], POLLIN, 0};
  char line[256];
  const bool said = ::poll(&waiting, 1, 30000) == 1 && ::read(ready[0], line, sizeof line) > 0;
  ::close(ready[0]);
  if (!said) kill();
  ASSERT_TRUE(said) << "tenterd is not ready: " << log();
}

int Daemon::stop() {
  send_signal(SIGTERM);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

void Daemon::kill() {
  send_signal(SIGKILL);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
}

void Daemon::send_signal(int signal) {
  if (pid_ > 0) ::kill(pid_, signal);
}

std::string Daemon::log() const {
  std::ostringstream text;
  text << std::ifstream(folder_.path() / "tenterd.log").rdbuf();
  return text.str();
}

Expected<client::Client> Daemon::connect(const std::string& user,
                                         std::chrono::milliseconds timeout) const {
  client::ClientOptions options;
  options.domain = domain();
  options.user = user;
  options.name = "test";
  options.timeout = timeout;
  return client::Client::connect(options);
}

std::string fake_job(const std::string& capture, const std::string& fake_options) {
  const auto model = model::preset_json("stvk_isotropic");
  return R"({"schema":"tenter.job","version":1,"kind":"fit","captures":[")" + capture +
         R"("],"model":)" + model.value_or("{}") + R"(,"options":{"fake":)" + fake_options + "}}";
}

}  // namespace tenter::test
