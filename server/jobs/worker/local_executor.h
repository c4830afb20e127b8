// SPDX-License-Identifier: GPL-3.0-or-later
// Workers as child processes of the daemon, up to a fixed number at once.
//
// Each worker is a process group of its own with an empty standard input, its log as output and a
// pipe back as descriptor 3; nothing else of the daemon's is open in it. One thread waits for
// pipes, exits and time limits, and sleeps without a timer while no limit is near. Any thread may
// call.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "server/jobs/worker/executor.h"

namespace tenter::jobs {

struct LocalExecutorConfig {
  std::filesystem::path worker;  ///< the program
  int slots = 0;                 ///< 0: one per core
  std::chrono::milliseconds kill_grace{3000};
  std::function<void()> wake;  ///< called (any thread) when poll() has something
};

class LocalExecutor final : public Executor {
 public:
  static Expected<std::unique_ptr<LocalExecutor>> create(LocalExecutorConfig config);
  ~LocalExecutor() override;  ///< kills every worker and waits for it

  Expected<void> start(const WorkOrder& order) override;
  void stop(ClaimKey claim, Manner manner) override;
  std::vector<WorkReport> poll() override;
  int slots() const override;
  int busy() const override;

 private:
  class Supervisor;
  explicit LocalExecutor(std::unique_ptr<Supervisor> supervisor);
  std::unique_ptr<Supervisor> supervisor_;
};

}  // namespace tenter::jobs
