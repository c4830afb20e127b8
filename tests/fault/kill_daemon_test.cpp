// SPDX-License-Identifier: GPL-3.0-or-later
// kill -9 of the daemon at 100 random instants, under submits, uploads and killed workers; then a
// history checker: every acknowledged job is there exactly once and has succeeded with the bytes
// that its specification demands, every acknowledged capture is there, and nothing was reported as
// damaged.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "server/jobs/spec.h"
#include "tests/fault/kill_protocol.h"
#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {
namespace {

using Time = std::chrono::steady_clock::time_point;

// One life of the daemon. Destroying it is kill -9.
class Daemon {
 public:
  explicit Daemon(const std::filesystem::path& store) {
    int in[2], out[2];
    if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) std::abort();
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(in[0], 0);
      ::dup2(out[1], 1);
      ::execl(TENTER_KILL_DAEMON, "kill-daemon", store.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    in_ = in[1];
    out_ = out[0];
  }
  ~Daemon() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    ::close(in_);
    ::close(out_);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  void say(const std::string& line) {
    const std::string text = line + "\n";
    [[maybe_unused]] const auto written = ::write(in_, text.data(), text.size());
  }
  /// The next reply; none when the time is up.
  std::optional<std::string> hear(Time until) {
    for (;;) {
      const auto end = buffer_.find('\n');
      if (end != std::string::npos) {
        std::string line = buffer_.substr(0, end);
        buffer_.erase(0, end + 1);
        return line;
      }
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(
                            until - std::chrono::steady_clock::now())
                            .count();
      if (left <= 0) return std::nullopt;
      pollfd wait{out_, POLLIN, 0};
      const timespec time{left / 1'000'000, left % 1'000'000 * 1000};
      if (::ppoll(&wait, 1, &time, nullptr) <= 0) return std::nullopt;
      char piece[4096];
      const ssize_t got = ::read(out_, piece, sizeof piece);
      if (got <= 0) return std::nullopt;
      buffer_.append(piece, static_cast<std::size_t>(got));
    }
  }

 private:
  pid_t pid_ = 0;
  int in_ = -1, out_ = -1;
  std::string buffer_;
};

// What the clients asked for and what they were told.
class Clients {
 public:
  explicit Clients(unsigned seed) : random_(seed) {}

  int pick(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  /// One more life of the daemon begins; what may be asked of it grows with the lives, so that a
  /// fast machine meets neither the user's quota nor hours of work.
  void another_life() { ++lives_; }

  /// A request without an answer is sent again, with its id, before anything new; nothing when this
  /// life has been asked enough.
  std::optional<std::string> next() {
    if (!unanswered_.empty()) {
      std::string again = unanswered_.front();
      unanswered_.pop_front();
      return again;
    }
    if (requests_ + uploads_ >= kRequestsPerLife * lives_) return std::nullopt;
    const int dice = pick(0, 99);
    if (dice < 80) {
      const int number = ++requests_;
      return "submit r" + std::to_string(number) + " n" + std::to_string(number) + " " +
             std::to_string(pick(0, 30));
    }
    if (dice < 90)
      return "upload " + std::to_string(++uploads_) + " " + std::to_string(pick(100, 3'000'000));
    return "kill_worker";
  }
  void unanswered(const std::string& command) {
    if (command.rfind("kill", 0) != 0) unanswered_.push_back(command);
  }
  void answered(const std::string& command, const std::string& answer) {
    std::istringstream words(answer);
    std::string what, request;
    words >> what >> request;
    if (what == "submitted") {
      std::string job, submit, id, nonce, sleep_ms;
      words >> job;
      std::istringstream(command) >> submit >> id >> nonce >> sleep_ms;
      EXPECT_EQ(id, request);
      jobs[job] = spec_text(nonce, R"({"sleep_ms":)" + sleep_ms + "}");
    } else if (what == "uploaded") {
      captures.insert(request);
    } else {
      EXPECT_EQ(what, "killed") << answer;
    }
  }

  std::map<std::string, std::string> jobs;  // acknowledged: id -> specification
  std::set<std::string> captures;

 private:
  static constexpr int kRequestsPerLife = 18;  // of 2,000 jobs that one user may have queued

  std::mt19937 random_;
  std::deque<std::string> unanswered_;
  int lives_ = 0, requests_ = 0, uploads_ = 0;
};

bool becomes_ready(Daemon& daemon, Time until) {
  for (;;) {
    const auto greeting = daemon.hear(until);
    if (!greeting) return false;
    if (*greeting == "ready") return true;
    ADD_FAILURE() << *greeting;  // a finding: something was damaged
  }
}

// Talks until the time is up and then kills.
void live_and_die(const std::filesystem::path& store, Clients& clients, Time death) {
  Daemon daemon(store);
  if (!becomes_ready(daemon, death)) return;
  clients.another_life();
  for (;;) {
    const auto command = clients.next();
    if (!command) return std::this_thread::sleep_until(death);  // its workers go on until then
    daemon.say(*command);
    const auto answer = daemon.hear(death);
    if (!answer) return clients.unanswered(*command);
    clients.answered(*command, *answer);
  }
}

void check_history(const std::filesystem::path& store, const Clients& clients) {
  Daemon daemon(store);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  ASSERT_TRUE(becomes_ready(daemon, end));
  daemon.say("drain");
  ASSERT_EQ(daemon.hear(end), "drained");
  daemon.say("dump");
  std::map<std::string, std::string> specs;  // job -> hash of its specification
  std::multiset<std::string> work;
  std::set<std::string> captures;
  std::int64_t attempts = 0;
  while (true) {
    const auto line = daemon.hear(end);
    ASSERT_TRUE(line);
    if (*line == "end") break;
    std::istringstream words(*line);
    std::string what, id, state, spec, result;
    int attempt = 0;
    words >> what >> id;
    if (what == "capture") {
      captures.insert(id);
      continue;
    }
    words >> state >> spec >> result >> attempt;
    attempts += attempt;
    EXPECT_EQ(state, "succeeded") << *line;
    EXPECT_EQ(result, R"({"captures":[")" + kCapture + R"("],"spec":")" + spec + R"("})");
    specs[id] = spec;
    work.insert(spec);
  }
  for (const auto& [job, text] : clients.jobs) {
    const std::string sha256 = MUST(parse_spec(text)).sha256;
    EXPECT_EQ(specs[job], sha256) << "job " << job;
    EXPECT_EQ(work.count(sha256), 1u);  // not once more under another id
  }
  for (const auto& spec : work) EXPECT_EQ(work.count(spec), 1u);
  for (const auto& capture : clients.captures) EXPECT_TRUE(captures.contains(capture)) << capture;
  std::printf("%zu acknowledged jobs (%zu in all, %lld starts), %zu acknowledged captures\n",
              clients.jobs.size(), specs.size(), static_cast<long long>(attempts),
              clients.captures.size());
}

TEST(KillDaemon, NothingAcknowledgedIsLostAtAHundredRandomInstants) {
  ::signal(SIGPIPE, SIG_IGN);
  const TemporaryFolder folder;
  const char* seed = std::getenv("TENTER_SEED");
  Clients clients(seed ? static_cast<unsigned>(std::stoul(seed)) : 20u);
  // instants from before the daemon is ready to well after, on a machine of any speed
  std::chrono::microseconds longest{};
  for (int start = 0; start < 2; ++start) {  // the first makes the store
    const auto now = std::chrono::steady_clock::now();
    Daemon daemon(folder.path() / "store");
    ASSERT_TRUE(becomes_ready(daemon, now + std::chrono::minutes(1)));
    const auto took = std::chrono::steady_clock::now() - now;
    longest = std::chrono::duration_cast<std::chrono::microseconds>(2 * took) +
              std::chrono::milliseconds(60);
  }
  for (int life = 0; life < 100; ++life) {
    const auto span =
        std::chrono::microseconds(clients.pick(1000, static_cast<int>(longest.count())));
    live_and_die(folder.path() / "store", clients, std::chrono::steady_clock::now() + span);
  }
  check_history(folder.path() / "store", clients);
  EXPECT_GT(clients.jobs.size(), 50u);  // else the test has shown nothing
  EXPECT_GT(clients.captures.size(), 5u);
}

TEST(KillDaemon, ItsWorkersDieWithIt) {
  ::signal(SIGPIPE, SIG_IGN);
  const TemporaryFolder folder;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  pid_t worker = 0;
  {
    Daemon daemon(folder.path() / "store");
    ASSERT_TRUE(becomes_ready(daemon, end));
    daemon.say("submit r n 600000");
    ASSERT_TRUE(daemon.hear(end));
    while (worker == 0) {
      daemon.say("worker");
      const auto heard = daemon.hear(end);
      ASSERT_TRUE(heard) << "the job's worker never said who it is";
      worker = std::stoi(heard->substr(7));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_EQ(::kill(worker, 0), 0);
  }
  EXPECT_TRUE(wait_until([&] {
    return !std::filesystem::exists("/proc/" + std::to_string(worker) + "/exe") ||
           ::kill(worker, 0) != 0;
  }));
}

}  // namespace
}  // namespace tenter::jobs
