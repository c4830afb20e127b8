// SPDX-License-Identifier: GPL-3.0-or-later
// A JobService on a folder of its own with the fake worker.
#pragma once

#include <algorithm>
#include <fstream>
#include <mutex>
#include <sstream>

#include "server/jobs/job_service.h"
#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {

inline ServiceConfig fake_config(const std::filesystem::path& store) {
  ServiceConfig config;
  config.store = store;
  config.worker = TENTER_FAKE_WORKER;
  config.parallel = 2;
  config.kill_grace = std::chrono::milliseconds(300);
  return config;
}

/// Uploads bytes as a capture; returns its id.
inline std::string upload(JobService& service, const std::string& bytes,
                          const std::string& user = "ada") {
  std::string sha256 = sha256_hex(bytes);
  auto state = MUST(service.upload_open({user, sha256, bytes.size()}));
  if (state.already_stored) return sha256;
  for (std::uint64_t i = 0; i < state.chunks; ++i) {
    MUST(service.upload_chunk(
        state.transfer, i,
        std::string_view(bytes).substr(i * state.chunk_bytes, state.chunk_bytes)));
  }
  return MUST(service.upload_commit(state.transfer)).capture.sha256;
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

class ServiceTest : public ::testing::Test {
 protected:
  void open() { open(fake_config(folder_.path() / "store")); }
  void open(ServiceConfig config) {
    service_.reset();
    service_ = MUST(JobService::open(std::move(config)));
    service_->set_listener([this](const JobEvent& event) {
      const std::lock_guard lock(mutex_);
      heard_.push_back(event);
    });
    service_->start();
    upload(*service_, kCaptureBytes);
  }
  JobId submit(const std::string& nonce, const std::string& fake = "{}") {
    return submit({.user = "ada", .request_id = "r-" + nonce, .spec_json = spec_text(nonce, fake)});
  }
  JobId submit(const SubmitRequest& request) { return MUST(service_->submit(request)).job.id; }
  JobRecord ended(JobId job) {
    EXPECT_TRUE(wait_until([&] { return is_final(MUST(service_->show(job)).state); }));
    return MUST(service_->show(job));
  }
  bool becomes(JobId job, JobState state) {
    return wait_until([&] { return MUST(service_->show(job)).state == state; });
  }
  std::vector<JobEvent> heard(JobId job) {
    const std::lock_guard lock(mutex_);
    std::vector<JobEvent> found;
    std::copy_if(heard_.begin(), heard_.end(), std::back_inserter(found),
                 [&](const JobEvent& event) { return event.job == job; });
    return found;
  }
  /// The worker's process id, once it has said it.
  int worker_pid(JobId job) {
    int pid = 0;
    wait_until([&] {
      for (const auto& event : heard(job)) {
        if (event.progress && event.progress->detail.rfind("pid ", 0) == 0) {
          pid = std::stoi(event.progress->detail.substr(4));
        }
      }
      return pid != 0;
    });
    return pid;
  }

  TemporaryFolder folder_{memory_folder()};
  std::mutex mutex_;
  std::vector<JobEvent> heard_;
  std::unique_ptr<JobService> service_;  // last: its thread uses the rest
};

}  // namespace tenter::jobs
