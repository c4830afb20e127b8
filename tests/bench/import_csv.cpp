// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-import-csv CSV JSON OUT.h5: the import alone, for benches that run without the command
// line.
#include <cstdio>

#include "common/base/text_file.h"
#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"
#include "common/capture/sheet_import/sheet_description.h"
#include "common/capture/sheet_import/sheet_import.h"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: tenter-import-csv CSV JSON OUT.h5\n");
    return 2;
  }
  const auto text = tenter::read_text_file(argv[2], 16000000);
  const auto capture = text && tenter::capture::describes_sheet(*text)
                           ? tenter::capture::import_sheet(argv[2], argv[1])
                           : tenter::capture::import_csv(argv[1], argv[2]);
  const auto done = capture ? tenter::capture::write_capture(*capture, argv[3])
                            : tenter::Expected<void>(tl::unexpected(capture.error()));
  if (done) return 0;
  std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}
