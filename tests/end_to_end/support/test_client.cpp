// SPDX-License-Identifier: GPL-3.0-or-later
// A client in a process of its own, to be stopped and killed by tests. Says "ready" when it is
// under way.
//
//   tenter-test-client DOMAIN USER ask            asks for the status again and again
//   tenter-test-client DOMAIN USER watch JOB      follows a job, prints a line for each update
//   tenter-test-client DOMAIN USER upload FILE    prints a line for each step of progress
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "client/api/client.h"

int main(int argc, char** argv) {
  using namespace tenter::client;
  if (argc < 4) return 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  ClientOptions options;
  options.domain = std::atoi(argv[1]);
  options.user = argv[2];
  options.name = "test-client";
  auto client = Client::connect(options);
  if (!client) {
    std::fprintf(stderr, "%s\n", client.error().message.c_str());
    return static_cast<int>(client.error().kind);
  }
  std::printf("ready\n");
  const std::string what = argv[3];
  if (what == "ask")
    for (;;) {
      (void)client->server_status();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  if (what == "watch" && argc > 4) {
    auto last = client->watch(argv[4], [](const JobUpdate& update) {
      std::printf("%s %s\n", std::string(job_state_name(update.state)).c_str(),
                  update.stage.c_str());
    });
    return last ? 0 : static_cast<int>(last.error().kind);
  }
  if (what == "upload" && argc > 4) {
    auto done = client->upload_capture(argv[4], [](const TransferProgress& progress) {
      std::printf("%llu\n", static_cast<unsigned long long>(progress.bytes_done));
    });
    return done ? 0 : static_cast<int>(done.error().kind);
  }
  return 2;
}
