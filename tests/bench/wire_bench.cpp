// SPDX-License-Identifier: GPL-3.0-or-later
// What the wire costs, in one run on one machine: connecting, asking, sending 200 MB beside what
// raw DDS and the disk do with as many bytes, listing a thousand jobs, and what the daemon takes
// while nobody asks.
//
//   tenter-bench-wire [MEGABYTES [upload]]   prints a table and, as the last line, the same as
//   JSON;
//                                            with "upload" of the uploads only
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "client/api/client.h"
#include "common/base/crc32c.h"
#include "common/base/sha256.h"
#include "common/wire/validate.h"
#include "tests/common/wire/domain.h"
#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"

namespace {

using namespace tenter;
namespace v1 = wire::v1;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values, double quantile = 0.5) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size() - 1))];
}

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "tenter-bench-wire: %s\n", why.c_str());
  std::exit(1);
}

template <class T>
T must(Expected<T> value) {
  if (!value) give_up(value.error().message);
  return std::move(*value);
}

json connecting(const test::Daemon& daemon) {
  std::vector<double> ms;
  for (int i = 0; i < 30; ++i) {
    const auto start = Clock::now();
    auto client = must(daemon.connect());
    must(client.server_status());
    ms.push_back(1e3 * seconds_since(start));
  }
  return {{"connect_and_status_ms_median", median(ms)},
          {"connect_and_status_ms_worst", median(ms, 1.0)}};
}

json asking(const test::Daemon& daemon) {
  auto client = must(daemon.connect());
  std::vector<double> ms;
  for (int i = 0; i < 3000; ++i) {
    const auto start = Clock::now();
    must(client.server_status());
    ms.push_back(1e3 * seconds_since(start));
  }
  return {{"request_ms_median", median(ms)}, {"request_ms_p99", median(ms, 0.99)}};
}

// The same bytes as chunks of 1 MiB between two participants, and nothing else done with them.
double raw_dds(std::uint32_t chunks) {
  test::Domain domain;
  wire::ParticipantOptions options;
  options.domain = domain.number();
  auto here = must(wire::Participant::create(options)),
       there = must(wire::Participant::create(options));
  const wire::Uuid transfer = wire::random_uuid();
  std::atomic<std::uint32_t> got{0};
  wire::ReaderHandlers<v1::Chunk> handlers;
  handlers.on_sample = [&](v1::Chunk&, const wire::Peer&) { ++got; };
  wire::Reader<v1::Chunk> reader(*there, wire::chunk_up_topic("bench", transfer), handlers);
  wire::Writer<v1::Chunk> writer(*here, wire::chunk_up_topic("bench", transfer));
  while (writer.matched_count() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  v1::Chunk chunk;
  chunk.transfer_id(transfer);
  chunk.count(chunks);
  chunk.data().assign(v1::CHUNK_BYTES, 0x5a);
  chunk.crc32c(crc32c(chunk.data().data(), chunk.data().size()));
  const auto start = Clock::now();
  for (std::uint32_t i = 0; i < chunks; ++i) {
    chunk.index(i);
    must(writer.write(chunk, std::chrono::seconds(20)).map([] { return 0; }));
  }
  while (got < chunks) std::this_thread::sleep_for(std::chrono::microseconds(200));
  return seconds_since(start);
}

double write_and_sync(const fs::path& folder, const fs::path& source) {
  std::ifstream stream(source, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  const auto start = Clock::now();
  const int file =
      ::open((folder / "sync-test").c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t put =
        ::write(file, bytes.data() + done, std::min<std::size_t>(bytes.size() - done, 1u << 20));
    if (put <= 0) give_up("the disk of the store cannot be written");
    done += static_cast<std::size_t>(put);
  }
  if (::fsync(file) != 0) give_up("the disk of the store cannot be synced");
  ::close(file);
  const double time = seconds_since(start);
  fs::remove(folder / "sync-test");
  return time;
}

// Each figure is the median of rounds with different bytes, in which the three that are compared
// run one after the other. An upload has two ends: all bytes on the server's disk and known to be
// those of the file (stored), and its content read and in the list (whole).
json uploading(const test::Daemon& daemon, std::size_t megabytes) {
  constexpr std::uint32_t kRounds = 7;
  std::vector<double> stored, whole, reading, dds, disk, hashing, share;
  double bytes = 0;
  for (std::uint32_t round = 1; round <= kRounds; ++round) {
    const fs::path file = daemon.folder() / "bench.h5";
    test::write_noise_capture(file, megabytes * 6700, 20, round);
    bytes = static_cast<double>(fs::file_size(file));
    auto client = must(daemon.connect());
    dds.push_back(raw_dds(static_cast<std::uint32_t>(bytes / v1::CHUNK_BYTES) + 1));
    disk.push_back(write_and_sync(daemon.folder(), file));
    auto start = Clock::now();
    double until_stored = 0;
    const auto progress = [&](const client::TransferProgress& now) {
      if (now.stored && until_stored == 0) until_stored = seconds_since(start);
    };
    must(client.upload_capture(file, progress));
    stored.push_back(until_stored);
    whole.push_back(seconds_since(start));
    share.push_back(std::max(dds.back(), disk.back()) / until_stored);
    start = Clock::now();
    must(sha256_file(file));
    hashing.push_back(seconds_since(start));
    start = Clock::now();
    const std::string inspect =
        std::string(TENTER_TENTERD) + " --inspect-capture " + file.string() + " >/dev/null";
    if (std::system(inspect.c_str()) != 0) give_up("the capture of the bench is not valid");
    reading.push_back(seconds_since(start));
    fs::remove(file);
  }
  const double mb = bytes / 1e6;
  const double smaller = std::min(mb / median(dds), mb / median(disk));
  return {{"upload_MB", mb},
          {"raw_dds_MB_per_s", mb / median(dds)},
          {"write_fsync_MB_per_s", mb / median(disk)},
          {"sha256_MB_per_s", mb / median(hashing)},
          {"reading_the_capture_s", median(reading)},
          {"upload_stored_MB_per_s", mb / median(stored)},
          {"upload_stored_share_of_smaller", mb / median(stored) / smaller},
          {"upload_stored_share_worst_round", median(share, 0.0)},
          {"upload_stored_share_best_round", median(share, 1.0)},
          {"upload_whole_MB_per_s", mb / median(whole)},
          {"upload_whole_share_of_smaller", mb / median(whole) / smaller}};
}

json listing(const test::Daemon& daemon) {
  auto client = must(daemon.connect());
  const fs::path file = daemon.folder() / "small.h5";
  test::write_noise_capture(file, 100, 1, 99);
  const std::string capture = must(client.upload_capture(file)).sha256;
  const auto start = Clock::now();
  for (int i = 0; i < 1000; ++i) {
    client::SubmitRequest request;
    request.spec_json =
        test::fake_job(capture, "{\"sleep_ms\": 600000, \"n\": " + std::to_string(i) + "}");
    must(client.submit(request));
  }
  const double submitting = seconds_since(start);
  client::JobFilter filter;
  filter.limit = 1000;
  std::vector<double> ms;
  for (int i = 0; i < 10; ++i) {
    const auto from = Clock::now();
    must(client.list_jobs(filter));
    ms.push_back(1e3 * seconds_since(from));
  }
  return {{"submit_ms_mean", submitting}, {"list_1000_jobs_ms_median", median(ms)}};
}

// VmRSS in MB and processor seconds so far.
std::pair<double, double> taken_by(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  double rss_kb = 0;
  for (std::string word; status >> word;)
    if (word == "VmRSS:") status >> rss_kb;
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string word;
  double ticks = 0;
  for (int i = 1; i <= 15 && (stat >> word); ++i)
    if (i >= 14) ticks += std::stod(word);
  return {rss_kb / 1024.0, ticks / static_cast<double>(::sysconf(_SC_CLK_TCK))};
}

json idling(const test::Daemon& daemon, const char* when) {
  constexpr double kSeconds = 10;
  const auto before = taken_by(daemon.pid());
  std::this_thread::sleep_for(std::chrono::duration<double>(kSeconds));
  const auto after = taken_by(daemon.pid());
  return {{std::string(when) + "_rss_MB", after.first},
          {std::string(when) + "_cpu_percent", 100.0 * (after.second - before.second) / kSeconds}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t megabytes = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 200;
  const bool all = argc < 3;
  json figures;
  if (!all) {
    test::Daemon daemon;
    figures.update(uploading(daemon, megabytes));
  } else {
    test::Daemon daemon;
    figures.update(idling(daemon, "idle"));
    figures.update(connecting(daemon));
    figures.update(asking(daemon));
    figures.update(uploading(daemon, megabytes));
    figures.update(idling(daemon, "idle_after_uploads"));
  }
  if (all) {
    test::Daemon daemon;
    figures.update(listing(daemon));
  }
  for (const auto& [name, value] : figures.items())
    std::printf("%-42s %10.3f\n", name.c_str(), value.get<double>());
  std::printf("%s\n", figures.dump().c_str());
  return 0;
}
