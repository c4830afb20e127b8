// SPDX-License-Identifier: GPL-3.0-or-later
// A worker for tests: the real process around a job function whose behaviour is in the
// specification's options.fake, so that every way to end can be asked for.
//
//   {"sleep_ms": 200, "ignore_stop": true, "fail": "why", "crash": true, "abort_below_deaths": 2,
//   "deaths_file": "...",
//    "count_to": 3,
//    "allocate_mb": 500, "no_result": true, "flood": true}
//
// The result depends on the specification and the captures' bytes only.
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "common/base/sha256.h"
#include "server/jobs/store/files.h"
#include "server/jobs/worker/worker_main.h"

namespace {

using nlohmann::json;
using namespace tenter;

/// Counts its attempts in a checkpoint, and dies until there were enough. The count is written
/// whole or not at all: whoever sees it may kill the worker at once.
Expected<void> count_attempts(const json& fake, const std::filesystem::path& checkpoints) {
  if (!fake.contains("count_to")) return {};
  std::filesystem::create_directories(checkpoints);
  int count = 0;
  std::ifstream(checkpoints / "count") >> count;
  auto kept = jobs::write_file_durably(checkpoints / "count", std::to_string(++count));
  if (!kept) return kept;
  if (count < fake["count_to"].get<int>()) ::raise(SIGABRT);
  return {};
}

void die_if_asked(const json& fake) {
  if (fake.value("crash", false)) ::raise(SIGABRT);
  const auto file = fake.value("deaths_file", std::string());
  if (file.empty()) return;
  int deaths = 0;
  std::ifstream(file) >> deaths;
  if (deaths >= fake.value("abort_below_deaths", 0)) return;
  std::ofstream(file) << deaths + 1;
  ::raise(SIGABRT);
}

Expected<void> run_fake(const jobs::JobInput& input,
                        const std::function<void(const jobs::JobProgress&)>& report,
                        const std::stop_token& stop) {
  const json spec = json::parse(input.spec_json);
  const json fake = spec.at("options").value("fake", json::object());
  std::fprintf(stderr, "fake worker runs\n");
  // in every report: of those that come at once only the last is heard
  const std::string who = "pid " + std::to_string(::getpid());
  report({"start", who, 0, 0, 0});
  die_if_asked(fake);
  if (auto counted = count_attempts(fake, input.checkpoints); !counted) return counted;
  if (fake.value("flood", false)) {
    for (int i = 0; i < 20000; ++i)
      report({"flood " + std::to_string(i), std::string(500, 'x'), i, 1.0, 0.5});
  }
  std::vector<std::vector<char>> memory;
  for (int mb = 0; mb < fake.value("allocate_mb", 0); mb += 10) memory.emplace_back(10u << 20, 'm');
  const int sleep_ms = fake.value("sleep_ms", 0);
  for (int slept = 0; slept < sleep_ms; slept += 5) {
    if (stop.stop_requested() && !fake.value("ignore_stop", false)) {
      return fail(ErrorKind::cancelled, "stopped");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    report({"sleep", who, slept, 1.0 / (1 + slept), double(slept) / sleep_ms});
  }
  if (fake.contains("fail")) return fail(ErrorKind::bad_input, fake["fail"].get<std::string>());
  if (fake.value("no_result", false)) return {};

  json result{{"spec", sha256_hex(input.spec_json)}, {"captures", json::array()}};
  for (const auto& [sha256, path] : input.captures) {
    auto found = sha256_file(path);
    if (!found) return tl::unexpected(found.error());
    result["captures"].push_back(*found);
  }
  std::ofstream document(input.staging / "result.json");
  document << result.dump() << "\n";
  std::ofstream residuals(input.staging / "residuals.h5");
  for (int i = 0; i < fake.value("residual_kb", 1); ++i) residuals << std::string(1024, 'r');
  residuals << sha256_hex(input.spec_json);
  document.close();
  residuals.close();
  if (!document || !residuals) return fail(ErrorKind::no_space, "the result could not be written");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  return jobs::worker_main(argc, argv, run_fake);
}
