// SPDX-License-Identifier: GPL-3.0-or-later
// A corrupt row or file is told and skipped; it never keeps the queue from opening.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "server/jobs/queue/queue.h"
#include "server/jobs/queue/sqlite.h"
#include "tests/server/jobs/queue_fixture.h"

namespace tenter::jobs {
namespace {

class QueueDamage : public QueueTest {
 protected:
  std::filesystem::path file() const { return folder_.path() / "queue.sqlite"; }
  void change_rows(const std::string& sql) {
    queue_.reset();
    Database(file(), Database::Mode::read_write).execute(sql);
  }
  std::string told() const {
    std::string all;
    for (const auto& line : queue_->findings()) all += line + "\n";
    return all;
  }
};

TEST_F(QueueDamage, ADamagedRowFailsItsJobAlone) {
  const JobId bad_state = submit("a"), bad_spec = submit("b"), sound = submit("c"),
              waits = submit("d", {.depends_on = {bad_spec}});
  change_rows(
      "UPDATE jobs SET state = 'rnning' WHERE id = 1; UPDATE specs SET json = 'x' WHERE sha256 ="
      " (SELECT spec_sha256 FROM jobs WHERE id = 2); UPDATE captures SET title = 'kept'");
  open();
  EXPECT_EQ(state(bad_state), JobState::failed);
  EXPECT_EQ(state(bad_spec), JobState::failed);
  EXPECT_EQ(state(waits), JobState::failed);
  EXPECT_EQ(state(sound), JobState::queued);
  EXPECT_NE(told().find("job 1: its row was damaged"), std::string::npos) << told();
  EXPECT_NE(told().find("job 2: its row was damaged"), std::string::npos);
  EXPECT_EQ(claim().id, sound);
  open();
  EXPECT_EQ(told(), "");  // told once
}

TEST_F(QueueDamage, ADamagedCaptureIdIsSkipped) {
  MUST(queue_->add_capture({sha256_hex("1"), "", "", "ada", 0, 7, "{}"}));
  change_rows("UPDATE captures SET sha256 = 'zz' || substr(sha256, 3) WHERE title = ''");
  open();
  EXPECT_NE(told().find("its id is damaged"), std::string::npos);
  EXPECT_EQ(MUST(queue_->captures({})).total, 1);
}

TEST_F(QueueDamage, AFileThatIsNoDatabaseIsMovedAside) {
  submit("a");
  queue_.reset();
  std::ofstream(file(), std::ios::trunc) << std::string(20000, 'x');
  std::filesystem::remove(file().string() + "-wal");
  open();
  EXPECT_NE(told().find("moved to queue.sqlite.damaged-1"), std::string::npos) << told();
  EXPECT_TRUE(std::filesystem::exists(file().string() + ".damaged-1"));
  submit("b");
}

TEST_F(QueueDamage, ABadPageCostsItsRowsOnly) {
  constexpr int kJobs = 3000;
  for (int i = 0; i < kJobs; ++i)
    submit("n" + std::to_string(i), {.user = "u" + std::to_string(i % 7)});
  queue_.reset();
  const auto size = std::filesystem::file_size(file());
  ASSERT_GT(size, 100u * 4096);
  {  // two pages in the middle
    std::fstream out(file(), std::ios::in | std::ios::out | std::ios::binary);
    for (const auto page : {size / 4096 / 2, size / 4096 / 3}) {
      out.seekp(static_cast<std::streamoff>(page * 4096));
      out << std::string(4096, '\xee');
    }
  }
  open();
  EXPECT_NE(told().find("rows saved from it"), std::string::npos) << told();
  const auto left = MUST(queue_->numbers());
  EXPECT_GT(left.queued, kJobs * 8 / 10) << told();
  submit("more");
  EXPECT_EQ(MUST(queue_->claim())->state, JobState::running);
}

TEST_F(QueueDamage, AFileOfANewerProgramIsRefused) {
  change_rows("INSERT INTO migrations VALUES(999, 'tomorrow')");
  const auto opened = Queue::open(config());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, ErrorKind::refused);
  EXPECT_NE(opened.error().message.find("newer tenterd"), std::string::npos);
}

// A limit on file size stands for a full disk, for root too.
TEST_F(QueueDamage, AFullDiskIsAnErrorAndNothingIsLost) {
  submit("a");
  queue_.reset();
  const pid_t child = ::fork();
  if (child == 0) {
    open();
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{2'000'000, 2'000'000};
    ::setrlimit(RLIMIT_FSIZE, &small);
    int taken = 0;
    ErrorKind kind = ErrorKind::internal;
    for (int i = 0; i < 2000; ++i) {
      const auto submitted = try_submit({}, "n" + std::to_string(i));
      if (!submitted) {
        kind = submitted.error().kind;
        break;
      }
      ++taken;
    }
    const auto after = queue_->numbers();
    ::_exit(kind == ErrorKind::no_space && taken > 5 && after && after->queued == taken + 1
                ? taken % 256
                : 255);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_NE(WEXITSTATUS(status), 255);
  open();
  EXPECT_EQ((MUST(queue_->numbers()).queued - 1) % 256,
            WEXITSTATUS(status));  // every acknowledged one
  EXPECT_EQ(told(), "");
}

}  // namespace
}  // namespace tenter::jobs
