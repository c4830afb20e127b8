// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-real-loops FOLDER_OF_IMPORTED_CAPTURES: `tenter fit --protocol loops` on measured
// data that is not part of the project, set by set: is it friction, and if so which. Nothing passes
// or fails here.
//
//   tests/bench/import_shared.sh IMPORTER DATA_DIR OUT_DIR
//   tenter-bench-real-loops OUT_DIR
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "server/estimation/friction_tests/loops/loop_fit.h"
#include "server/jobs/friction_test/points/loops_of_captures.h"
#include "server/jobs/friction_test/points/rate_question.h"

namespace {

using namespace tenter;

struct Set {
  const char* words;
  const char* folder;
  const char* part;  ///< of the file names
  const char* direction;
};

constexpr Set kSets[] = {
    {"warp knit, along x", "warpknit-pp-biaxial", "mean_0_90", "weft"},
    {"warp knit, along y", "warpknit-pp-biaxial", "mean_0_90", "warp"},
    {"friction damper, 0.5 inch at three rates", "friction-damper-hysteresis", "amp0.5in", ""},
    {"friction damper, nine sines", "friction-damper-hysteresis", "sine_", ""},
    {"foam, five specimens", "foam-cyclic-tension", "leap", ""},
    {"foam, one specimen", "foam-cyclic-tension", "specimen1", ""},
    {"VHB 4910, loops at two rates", "vhb4910-rate-hysteresis", "cyclic", ""},
    {"VHB 4910, loops and holds", "vhb4910-rate-hysteresis", "", ""},
    {"VHB 4910, one loop", "vhb4910-rate-hysteresis", "rate0p01_stretch2p0", ""},
};

std::vector<std::pair<std::string, capture::Capture>> captures_of(
    const Set& set, const std::filesystem::path& root) {
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(root / set.folder, none))
    if (entry.path().extension() == ".h5" &&
        entry.path().filename().string().find(set.part) != std::string::npos)
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::pair<std::string, capture::Capture>> captures;
  for (const auto& file : files)
    if (auto capture = capture::read_capture(file.string()))
      captures.emplace_back(file.stem().string(), std::move(*capture));
  return captures;
}

void print(const estimation::LoopEstimate& found, std::size_t readings) {
  std::printf(
      "  %zu readings, missed %.1f %% of the load%s; work lost %.1f %%, of the model %.1f %%\n",
      readings, 100.0 * found.missed_share,
      found.noise_is_from_fit ? " (intervals from what is left)" : "", 100.0 * found.lost_share,
      100.0 * found.lost_share_of_model);
  for (const estimation::FrictionNumber& n : found.friction.numbers)
    if (n.is_told)
      std::printf("    %-4s %10.4g  (%.4g to %.4g) %s\n", n.name.c_str(), n.value, n.lo.value_or(0),
                  n.hi.value_or(0), n.unit.c_str());
    else
      std::printf("    %-4s %s\n", n.name.c_str(), n.words.c_str());
  if (found.friction.gains_below > 0.0)
    std::printf("    a step may gain work below a strain of %.3g\n", found.friction.gains_below);
}

void run(const Set& set, const std::filesystem::path& root) {
  const auto captures = captures_of(set, root);
  std::printf("\n%s (%zu captures)\n", set.words, captures.size());
  if (captures.empty()) return;
  const std::clock_t begin = std::clock();
  const auto seconds = [&] { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; };
  const auto loops = jobs::loops_of(captures, set.direction);
  if (!loops) return void(std::printf("  %s\n", loops.error().message.c_str()));
  const auto found = fit_loops(loops->table, loops->measure);
  if (!found) return void(std::printf("  %s\n", found.error().message.c_str()));
  const auto rate = jobs::ask_for_rate(loops->captures, found->friction.model, {});
  if (!rate) return void(std::printf("  %s\n", rate.error().message.c_str()));
  std::printf("  %d runs, %d passed over. %s%s\n", loops->runs, loops->runs_passed_over,
              rate->answer == jobs::RateAnswer::viscosity ? "REFUSED: " : "", rate->words.c_str());
  if (rate->answer != jobs::RateAnswer::viscosity) print(*found, loops->table.readings.size());
  std::printf("    [%.1f CPU s]\n", seconds());
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: tenter-bench-real-loops FOLDER_OF_IMPORTED_CAPTURES\n");
    return 2;
  }
  for (const Set& set : kSets) run(set, arguments[1]);
  return 0;
}
