// SPDX-License-Identifier: GPL-3.0-or-later
// A daemon for the kill test: the real JobService with the fake worker, driven over its standard
// input.
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <thread>

#include "tests/fault/kill_protocol.h"
#include "tests/server/jobs/job_service_fixture.h"

namespace {

using namespace tenter;
using namespace tenter::jobs;

void reply(const std::string& line) {
  std::cout << line << std::endl;
}

void dump(JobService& service) {
  for (JobFilter filter{.limit = 1000};;) {
    const JobPage page = MUST(service.list(filter));
    for (const auto& job : page.jobs) {
      std::string result = "-";
      if (job.state == JobState::succeeded) {
        const auto file = service.result(job.id);  // checks the bytes
        result = file ? bytes_of(file->path) : "missing";
        if (!result.empty() && result.back() == '\n') result.pop_back();
      }
      reply("job " + job_id_text(job.id) + " " + std::string(name_of(job.state)) + " " +
            job.spec_sha256 + " " + result + " " + std::to_string(job.attempt));
    }
    if (page.next_before == 0) break;
    filter.before = page.next_before;
  }
  for (const auto& capture : MUST(service.captures({.limit = 1000})).captures) {
    if (service.capture_file(capture.sha256)) reply("capture " + capture.sha256);
  }
  reply("end");
}

void obey(JobService& service, std::istringstream words, std::atomic<int>& worker) {
  std::string command;
  words >> command;
  if (command == "submit") {
    std::string request, nonce, sleep_ms;
    words >> request >> nonce >> sleep_ms;
    const auto submitted =
        service.submit({.user = "ada",
                        .request_id = request,
                        .spec_json = spec_text(nonce, R"({"sleep_ms":)" + sleep_ms + "}"),
                        .max_attempts = 10});
    reply(submitted ? "submitted " + request + " " + job_id_text(submitted->job.id)
                    : "error " + submitted.error().message);
  } else if (command == "upload") {
    unsigned seed = 0;
    std::size_t size = 0;
    words >> seed >> size;
    reply("uploaded " + upload(service, fault::bytes_of_seed(seed, size)));
  } else if (command == "kill_worker") {
    const int pid = worker.exchange(0);
    if (pid != 0) ::kill(pid, SIGKILL);
    reply("killed " + std::to_string(pid));
  } else if (command == "worker") {
    reply("worker " + std::to_string(worker));
  } else if (command == "drain") {
    while (true) {
      const auto numbers = MUST(service.status()).queue;
      if (numbers.queued + numbers.running == 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    reply("drained");
  } else if (command == "dump") {
    dump(service);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  auto service = MUST(JobService::open(fake_config(argv[1])));
  for (const auto& finding : service->findings()) reply("finding " + finding);
  std::atomic<int> worker{0};
  service->set_listener([&worker](const JobEvent& event) {
    if (!event.progress) worker = 0;
    if (event.progress && event.progress->detail.rfind("pid ", 0) == 0) {
      worker = std::stoi(event.progress->detail.substr(4));
    }
  });
  service->start();
  upload(*service, kCaptureBytes);
  reply("ready");
  for (std::string line; std::getline(std::cin, line);)
    obey(*service, std::istringstream(line), worker);
  return 0;
}
