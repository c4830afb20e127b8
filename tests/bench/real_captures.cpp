// SPDX-License-Identifier: GPL-3.0-or-later
// The diagnosis on measured data that is not part of the project: prints, for each set of captures,
// the verdicts, the errors and the R2 in sample and on left-out protocols. Nothing passes or fails
// here.
//
//   tests/bench/import_shared.sh IMPORTER DATA_DIR OUT_DIR
//   tenter-bench-real OUT_DIR
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "common/model/presets.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/verdicts/verdict_words.h"

namespace {

using tenter::diagnosis::VerdictKind;

struct Set {
  const char* words;
  const char* folder;
  const char* beginning;  ///< of the file names
  const char* model;
};

constexpr Set kSets[] = {
    {"warp-knit, four biaxial protocols", "warpknit-pp-biaxial", "mean_0_90", "stvk_orthotropic"},
    {"acrylic adhesive, stepped shear with holds", "oca-cyclic-shear-relaxation", "",
     "stvk_diagonal"},
    {"acrylic elastomer, cycles and relaxation", "vhb4910-rate-hysteresis", "", "stvk_orthotropic"},
    {"friction damper, nine sines", "friction-damper-hysteresis", "", "stvk_diagonal"},
    {"knit, acrylic garter along the wales", "knit-uniaxial-tracked", "acrylic_garter_y",
     "stvk_diagonal"},
    {"knit, cotton garter along the courses", "knit-uniaxial-tracked", "cotton_garter_x",
     "stvk_diagonal"},
};

void run(const Set& set, const std::filesystem::path& root) {
  tenter::diagnosis::Request request;
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(root / set.folder, none))
    if (entry.path().extension() == ".h5" &&
        entry.path().filename().string().starts_with(set.beginning))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    auto capture = tenter::capture::read_capture(file.string());
    if (!capture) {
      std::printf("%s\n", capture.error().message.c_str());
      return;
    }
    request.captures.emplace_back(file.stem().string(), std::move(*capture));
  }
  std::printf("\n%s (%zu captures, from %s)\n", set.words, files.size(), set.model);
  if (files.empty()) return;
  request.model = *tenter::model::preset(set.model);
  tenter::diagnosis::Control control;
  control.threads = 2;
  const auto start = std::chrono::steady_clock::now();
  const auto found = tenter::diagnosis::diagnose(request, control);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!found) {
    std::printf("  %s\n", found.error().message.c_str());
    return;
  }
  for (const auto& verdict : found->verdicts) {
    if (verdict.kind == VerdictKind::not_excited) continue;
    std::printf("  %-13s %-26s %5.1f %%", tenter::diagnosis::verdict_name(verdict.kind),
                verdict.effect.c_str(), 100.0 * verdict.size);
    for (const std::string& other : verdict.alternatives) std::printf("  or %s", other.c_str());
    std::printf("\n");
  }
  std::printf("  error %.3f -> %.3f   R2 %.3f -> %.3f   noise floor %.3f   %.1f s\n",
              found->before.error, found->after.error, found->before.r2, found->after.r2,
              found->noise_floor, seconds);
  if (found->held_out_before && found->held_out_after)
    std::printf("  left-out %s: R2 %.3f -> %.3f\n", found->held_out_kind.c_str(),
                found->held_out_before->r2, found->held_out_after->r2);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: tenter-bench-real FOLDER_OF_IMPORTED_CAPTURES\n");
    return 2;
  }
  for (const Set& set : kSets) run(set, argv[1]);
  return 0;
}
