// SPDX-License-Identifier: GPL-3.0-or-later
// Writes captures of a made cloth for tests of the command:
// tenter-sheet-captures FOLDER NODES FRAMES ROLE...
#include <cstdlib>
#include <iostream>

#include "common/capture/file/capture_file.h"
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  for (int i = 4; i < argc; ++i) {
    tenter::testing::SheetCaptureOptions options;
    options.role = argv[i];
    options.nodes = std::atoi(argv[2]);
    options.frames = std::atoi(argv[3]);
    options.seed = static_cast<unsigned>(i);
    const std::string path = std::string(argv[1]) + "/" + argv[i] + ".h5";
    const auto written =
        tenter::capture::write_capture(tenter::testing::sheet_capture(options), path);
    if (!written) {
      std::cerr << written.error().message << "\n";
      return 1;
    }
  }
  return 0;
}
