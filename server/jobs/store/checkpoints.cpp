// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/checkpoints.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "common/base/sha256.h"
#include "server/jobs/store/files.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

namespace {

struct Kept {
  std::string name;
  fs::file_time_type last{};  // its newest file's
  std::uint64_t bytes = 0;
};

Kept look_at(const fs::path& folder) {
  Kept kept{folder.filename().string(), {}, 0};
  std::error_code error;
  kept.last = fs::last_write_time(folder, error);
  for (auto it = fs::recursive_directory_iterator(folder, error);
       !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    std::error_code gone;
    if (!it->is_regular_file(gone)) continue;
    const std::uintmax_t size = it->file_size(gone);
    if (!gone) kept.bytes += size;
    const auto time = it->last_write_time(gone);
    if (!gone) kept.last = std::max(kept.last, time);
  }
  return kept;
}

}  // namespace

Expected<Checkpoints> Checkpoints::open(fs::path folder, const std::string& engine) {
  const fs::path mark = folder / "engine";
  const auto before = read_file(mark, 1024);
  if (!before || *before != engine) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  if (auto done = make_folder(folder); !done) return tl::unexpected(done.error());
  if (!before || *before != engine)
    if (auto done = write_file_durably(mark, engine); !done) return tl::unexpected(done.error());
  Checkpoints checkpoints(std::move(folder));
  checkpoints.prune({});
  return checkpoints;
}

void Checkpoints::drop(const std::string& spec_sha256) {
  if (!is_sha256(spec_sha256)) return;
  std::error_code ignored;
  fs::remove_all(of(spec_sha256), ignored);
}

void Checkpoints::prune(const std::set<std::string>& running, std::size_t most,
                        std::uint64_t most_bytes) {
  std::vector<Kept> all;
  std::error_code error;
  for (auto it = fs::directory_iterator(folder_, error); !error && it != fs::directory_iterator();
       it.increment(error))
    if (is_sha256(it->path().filename().string())) all.push_back(look_at(it->path()));
  std::uint64_t bytes = 0;
  for (const Kept& kept : all) bytes += kept.bytes;
  std::size_t count = all.size();
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) {
    return a.last != b.last ? a.last < b.last : a.name < b.name;
  });
  for (const Kept& kept : all) {
    if (count <= most && bytes <= most_bytes) return;
    if (running.contains(kept.name)) continue;
    drop(kept.name);
    --count;
    bytes -= kept.bytes;
  }
}

}  // namespace tenter::jobs
