// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-sheets [FILE.h5]: what captures of sheets cost.
//
// Without arguments: 10,000 vertices over 40 frames written, read, exported to tables, imported
// from them, and made into a sequence of 25 x 25 nodes; seconds and parts of the reading. With a
// capture: what a sequence of about 40 frames of its first run takes of it and what it leaves out.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "common/capture/file/capture_file.h"
#include "common/capture/sheet/sheet_export.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "server/estimation/sequences/from_capture.h"
#include "tests/common/capture/sheet/support.h"
#include "tests/common/capture/support.h"

namespace {

using namespace tenter;

double seconds(const std::function<bool()>& work) {
  const auto before = std::chrono::steady_clock::now();
  if (!work()) std::printf("failed\n");
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

int time_the_ways() {
  const capture::test::TempFolder folder;
  const capture::Capture made = capture::test::rippled_sheet_capture(100, 40);
  const std::string file = folder.path("sheet.h5");
  const double write = seconds([&] { return capture::write_capture(made, file).has_value(); });
  const double read = seconds([&] { return capture::read_capture(file).has_value(); });
  const std::string tables = folder.path("sheet.json");
  const double exported = seconds([&] { return capture::export_sheet(made, tables).has_value(); });
  const double imported = seconds([&] { return capture::import_sheet(tables).has_value(); });
  std::string used;
  const double sequence = seconds([&] {
    const auto captured = estimation::sequence_from_capture(made);
    if (captured) used = in_words(captured->use);
    return captured.has_value();
  });
  std::printf("10,000 vertices x 40 frames, %.1f MB on disk\n",
              static_cast<double>(std::filesystem::file_size(file)) / 1e6);
  const auto line = [read](const char* what, double time) {
    std::printf("  %-34s %7.3f s  %7.1f readings\n", what, time, time / read);
  };
  line("written", write);
  line("read", read);
  line("exported to CSV", exported);
  line("imported from CSV", imported);
  line("made into a sequence, 25 x 25", sequence);
  std::printf("  %s\n", used.c_str());
  return 0;
}

int look_at(const char* file) {
  const auto read = capture::read_capture_guarded(file);
  if (!read) {
    std::printf("%s\n", read.error().message.c_str());
    return 2;
  }
  estimation::FromCaptureOptions options;
  const std::size_t step = 1 + read->frame_count() / 40;
  for (std::size_t f = 0; f < read->frame_count() && read->run[f] == 0; f += step)
    options.frames.push_back(f);
  const auto captured = estimation::sequence_from_capture(*read, options);
  if (!captured) {
    std::printf("%s\n", captured.error().message.c_str());
    return 2;
  }
  std::printf("%s\n%s\n", read->title.c_str(), in_words(captured->use).c_str());
  int frame = 0;
  for (const estimation::SequenceFrame& at : captured->sequence.frames) {
    std::printf("  frame %d: ", ++frame);
    for (const double force : at.forces_N) std::printf("%.3g N ", force);
    std::printf("\n");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 1) return time_the_ways();
  if (argc == 2) return look_at(argv[1]);
  std::fprintf(stderr, "usage: tenter-bench-sheets [FILE.h5]\n");
  return 2;
}
