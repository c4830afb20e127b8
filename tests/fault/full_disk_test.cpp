// SPDX-License-Identifier: GPL-3.0-or-later
// A full disk is an error to the user and nothing else: what was acknowledged before stays, what is
// asked for afterwards works again.
//
// The disk is a small tmpfs in a mount namespace of a child process (of a user namespace too when
// not root). Where the system forbids that, a limit on the size of files stands for it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>

#include "tests/server/jobs/job_service_fixture.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;

bool mount_small_disk(const fs::path& at) {
  const int flags = ::geteuid() == 0 ? CLONE_NEWNS : CLONE_NEWNS | CLONE_NEWUSER;
  return ::unshare(flags) == 0 &&
         ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         ::mount("tenter-test", at.c_str(), "tmpfs", 0, "size=24m") == 0;
}

struct Disk {
  fs::path folder;
  bool small = false;  // else by file size
  fs::path filler() const { return folder / "filler"; }
  void fill(pid_t worker) const {
    if (small) {
      std::ofstream out(filler());
      const std::string piece(4096, 'f');
      while (out.write(piece.data(), static_cast<std::streamsize>(piece.size())).flush()) {
      }
    } else {
      const rlimit limit{1'000'000, RLIM_INFINITY};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      ::prlimit(worker, RLIMIT_FSIZE, &limit, nullptr);
    }
  }
  void free() const {
    if (small) {
      fs::remove(filler());
    } else {
      const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
      ::setrlimit(RLIMIT_FSIZE, &none);
    }
  }
};

bool ends(JobService& service, JobId job) {
  return wait_until([&] { return is_final(MUST(service.show(job)).state); });
}

// In a child process; failures are printed by GoogleTest and counted by the parent through the exit
// code.
void live_through_a_full_disk(const Disk& disk) {
  const fs::path store = disk.folder / "store";
  std::vector<std::string> trouble;
  std::mutex mutex;
  ServiceConfig config = fake_config(store);
  config.parallel = 1;
  config.log = [&](const std::string& line) {
    const std::lock_guard lock(mutex);
    trouble.push_back(line);
  };
  std::vector<JobId> acknowledged;
  int refused = 0;
  {
    auto service = MUST(JobService::open(config));
    std::atomic<pid_t> worker{0};
    service->set_listener([&worker](const JobEvent& event) {
      if (event.progress && event.progress->detail.rfind("pid ", 0) == 0) {
        worker = std::stoi(event.progress->detail.substr(4));
      }
    });
    service->start();
    upload(*service, kCaptureBytes);
    const auto submit = [&](const std::string& nonce, const std::string& fake) {
      return service->submit(
          {.user = "ada", .request_id = nonce, .spec_json = spec_text(nonce, fake)});
    };
    const JobId before = MUST(submit("before", "{}")).job.id;
    EXPECT_TRUE(ends(*service, before));
    const JobId slow = MUST(submit("slow", R"({"sleep_ms": 400, "residual_kb": 6000})")).job.id;
    const auto is_slow = [&] {
      const auto progress = MUST(service->show(slow)).progress;
      return progress && progress->stage == "sleep";
    };
    EXPECT_TRUE(wait_until(is_slow));

    disk.fill(worker);
    const auto open = service->upload_open({"ada", sha256_hex("big"), 8'000'000});
    ASSERT_FALSE(open);
    EXPECT_EQ(open.error().kind, ErrorKind::no_space) << open.error().message;
    for (int i = 0; i < 60; ++i) {
      auto submitted = submit("full" + std::to_string(i), "{}");
      if (submitted) {
        acknowledged.push_back(submitted->job.id);
      } else {
        ++refused;
        EXPECT_EQ(submitted.error().kind, ErrorKind::no_space) << submitted.error().message;
      }
    }
    EXPECT_GT(refused, 0);
    EXPECT_EQ(MUST(service->show(before)).state, JobState::succeeded);  // reading goes on
    EXPECT_EQ(bytes_of(MUST(service->result(before)).path).substr(0, 1), "{");
    std::this_thread::sleep_for(
        std::chrono::milliseconds(700));  // the slow job meets the full disk

    disk.free();
    EXPECT_TRUE(ends(*service, slow));
    const JobRecord ended = MUST(service->show(slow));
    EXPECT_EQ(ended.state, JobState::failed);
    EXPECT_EQ(ended.error.value_or(Error{}).kind, ErrorKind::no_space) << ended.message;
    EXPECT_EQ(MUST(service->retry("ada", "again", slow)).state, JobState::queued);
    EXPECT_TRUE(ends(*service, slow));
    EXPECT_EQ(MUST(service->show(slow)).state, JobState::succeeded)
        << MUST(service->show(slow)).message;
    const JobId after = MUST(submit("after", "{}")).job.id;
    acknowledged.insert(acknowledged.end(), {before, slow, after});
    for (const JobId job : acknowledged) {
      EXPECT_TRUE(ends(*service, job));
      const JobState state = MUST(service->show(job)).state;
      const auto error = MUST(service->show(job)).error;
      EXPECT_TRUE(state == JobState::succeeded ||
                  error.value_or(Error{}).kind == ErrorKind::no_space)
          << MUST(service->show(job)).message;
    }
    upload(*service, std::string(3'000'000, 'u'));
  }
  auto service = MUST(JobService::open(config));
  EXPECT_TRUE(service->findings().empty()) << service->findings().front();
  EXPECT_EQ(MUST(service->list({})).total, static_cast<std::int64_t>(acknowledged.size()));
  std::printf("%s: %zu jobs acknowledged, %d refused; the scheduler said: %s\n",
              disk.small ? "tmpfs of 24 MB" : "limit on file size", acknowledged.size(), refused,
              trouble.empty() ? "nothing" : trouble.front().c_str());
}

// Two ways to be full; `wanted_small` false: always by file size.
void run_in_child(bool wanted_small) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const Disk disk{folder.path(), wanted_small && mount_small_disk(folder.path())};
    live_through_a_full_disk(disk);
    std::fflush(nullptr);
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST(FullDisk, OfADiskThatIsFull) {
  run_in_child(true);
}
TEST(FullDisk, OfFilesThatMayNotGrow) {
  run_in_child(false);
}

}  // namespace
}  // namespace tenter::jobs
