// SPDX-License-Identifier: GPL-3.0-or-later
// What the queue and the store cost: prints medians of one run in a folder of the given disk. Each
// answer is checked before its time counts. Usage: tenter-bench-jobs [FOLDER]
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/base/sha256.h"
#include "server/jobs/queue/queue.h"
#include "server/jobs/store/store.h"
#include "server/jobs/store/uploads.h"

namespace {

using namespace tenter;
using namespace tenter::jobs;
namespace fs = std::filesystem;

template <class T>
T must(Expected<T> value) {
  if (!value) {
    std::fprintf(stderr, "%s\n", value.error().message.c_str());
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return *std::move(value);
}

void check(bool right, const char* what) {
  if (right) return;
  std::fprintf(stderr, "wrong answer: %s\n", what);
  std::exit(1);
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median_ms(int repeats, const std::function<void()>& work) {
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(repeats));
  for (int i = 0; i < repeats; ++i) times.push_back(1e3 * seconds(work));
  std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
  return times[static_cast<std::size_t>(repeats / 2)];
}

std::string spec_of(int nonce, const std::string& capture) {
  return R"({"schema":"tenter.job","version":1,"kind":"fit","captures":[")" + capture +
         R"("],"model":{"pad":")" + std::string(4000, 'm') + R"("},"options":{"nonce":)" +
         std::to_string(nonce) + "}}";
}

void bench_queue(const fs::path& folder) {
  constexpr int kJobs = 1000;
  const std::string capture = sha256_hex("capture");
  QueueConfig config;
  config.file = folder / "queue.sqlite";
  config.lease = std::chrono::hours(1);
  auto queue = must(Queue::open(config));
  must(queue->add_capture({capture, "pull", "homogeneous_strain", "u0", 0, 7, "{}"}));
  const double submit = seconds([&] {
    for (int i = 0; i < kJobs; ++i) {
      SubmitRequest request;
      request.user = "u" + std::to_string(i % 5);
      request.request_id = std::to_string(i);
      must(queue->submit(request, must(parse_spec(spec_of(i, capture)))));
    }
  });
  JobFilter all;
  all.limit = kJobs;
  check(must(queue->list(all)).jobs.size() == kJobs, "list");
  std::printf("submit, durable:            %8.0f jobs/s\n", kJobs / submit);
  std::printf("list of 1,000 queued jobs:  %8.2f ms\n",
              median_ms(21, [&] { must(queue->list(all)); }));
  std::printf("show one job:               %8.3f ms\n",
              median_ms(101, [&] { must(queue->show(500)); }));
  std::printf("numbers for status:         %8.3f ms\n",
              median_ms(101, [&] { must(queue->numbers()); }));
  std::printf("claim by fair share:        %8.2f ms\n",
              median_ms(101, [&] { check(must(queue->claim()).has_value(), "claim"); }));
  queue.reset();
  std::printf("open with 1,000 jobs:       %8.2f ms\n",
              1e3 * seconds([&] { queue = must(Queue::open(config)); }));
  check(must(queue->numbers()).queued == kJobs, "everything is queued again");
}

void bench_upload(const fs::path& folder) {
  constexpr std::size_t kSize = 200u << 20;
  std::string bytes(kSize, 0);
  std::mt19937_64 random(7);
  for (std::size_t i = 0; i < kSize; i += 8) {
    const auto word = random();
    std::copy_n(reinterpret_cast<const char*>(&word), 8,
                bytes.begin() + static_cast<std::ptrdiff_t>(i));
  }
  const std::string sha256 = sha256_hex(bytes);
  const double hash = seconds([&] { check(sha256_hex(bytes) == sha256, "hash"); });
  const auto chunk_of = [&](std::uint64_t i) {
    return std::string_view(bytes).substr(i * Uploads::kChunkBytes, Uploads::kChunkBytes);
  };
  double raw = 1e9, upload = 1e9;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const fs::path file = folder / "raw";
    raw = std::min(
        raw, seconds([&] {
          const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
          for (std::uint64_t i = 0; i < kSize / Uploads::kChunkBytes; ++i) {
            const auto chunk = chunk_of(i);
            check(::write(fd, chunk.data(), chunk.size()) == static_cast<ssize_t>(chunk.size()),
                  "write");
          }
          ::fsync(fd);
          ::close(fd);
        }));
    fs::remove(file);
    const fs::path root = folder / ("store" + std::to_string(repeat));
    auto store = must(Store::open(root));
    auto uploads = must(Uploads::open(root / "uploads"));
    upload = std::min(upload, seconds([&] {
                        const auto state = must(uploads->open_transfer({"u", sha256, kSize}));
                        for (std::uint64_t i = 0; i < state.chunks; ++i) {
                          must(uploads->write_chunk(state.transfer, i, chunk_of(i)));
                        }
                        const auto done = must(uploads->finish(state.transfer));
                        must(store->adopt(done.path, sha256));
                        must(uploads->drop(state.transfer));
                      }));
    check(fs::file_size(must(store->path(sha256))) == kSize, "the object");
  }
  const double mb = kSize / 1e6;
  std::printf("200 MB: write + fsync       %8.0f MB/s\n", mb / raw);
  std::printf("200 MB: SHA-256 in memory   %8.0f MB/s\n", mb / hash);
  std::printf("200 MB: upload, committed   %8.0f MB/s  (%.0f %% of write + fsync)\n", mb / upload,
              100 * raw / upload);
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path parent = argc > 1 ? fs::path(argv[1]) : fs::temp_directory_path();
  std::string pattern = (parent / "tenter-bench-XXXXXX").string();
  if (!::mkdtemp(pattern.data())) return 1;
  bench_queue(pattern);
  bench_upload(pattern);
  fs::remove_all(pattern);
}
