// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-twin: writes synthetic captures with a hidden effect as capture files.
//
//   tenter-twin internal_friction --size 5 --suite rich --seed 3 --only strip_x --out friction.h5
#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "tests/twin/generator.h"
#include "tests/twin/hidden_effects.h"
#include "tests/twin/suite.h"

namespace {

struct Options {
  tenter::twin::TwinCase twin_case;
  std::string only;
  std::string out;
};

bool ends_with(const std::string& text, const std::string& tail) {
  return text.size() >= tail.size() &&
         text.compare(text.size() - tail.size(), tail.size(), tail) == 0;
}

void list() {
  std::cout << "effects:\n";
  for (const tenter::twin::HiddenEffect& effect : tenter::twin::hidden_effects()) {
    std::cout << "  " << effect.id;
    std::string last;
    for (const std::string& variant : effect.variants) {
      if (variant != last) std::cout << (last.empty() ? " : " : ", ") << variant;
      last = variant;
    }
    std::cout << (effect.foreign ? "   (foreign: the diagnosis has no name for it)\n" : "\n");
  }
  std::cout << "suites:\n";
  for (const std::string& suite : tenter::twin::suite_names()) std::cout << "  " << suite << "\n";
}

int fail(const tenter::Error& error) {
  std::cerr << "tenter-twin: " << error.message << "\n";
  return static_cast<int>(error.kind);
}

int run(const Options& options) {
  const auto twin = tenter::twin::make_twin(options.twin_case);
  if (!twin) return fail(twin.error());
  const bool one_file = ends_with(options.out, ".h5");
  if (one_file && options.only.empty() && twin->captures.size() > 1)
    return fail({tenter::ErrorKind::bad_input,
                 "the suite has several captures: name one with --only, or a folder with --out"});
  bool written = false;
  for (const tenter::capture::Capture& capture : twin->captures) {
    const std::string name = capture.protocol.name.substr(capture.protocol.name.rfind(' ') + 1);
    if (!options.only.empty() && options.only != name) continue;
    const std::string path = one_file ? options.out : options.out + "/" + name + ".h5";
    if (const auto done = tenter::capture::write_capture(capture, path); !done)
      return fail(done.error());
    std::cout << path << ": " << capture.frame_count() << " frames\n";
    written = true;
  }
  if (!written)
    return fail({tenter::ErrorKind::bad_input, "the suite has no capture '" + options.only + "'"});
  for (const tenter::twin::Hidden& hidden : twin->hidden)
    std::cout << "hidden: " << hidden.id << " " << hidden.variant << ", amplitude "
              << hidden.amplitude << " " << hidden.unit << ", size " << hidden.achieved_size
              << "\n";
  std::cout << "baseline: " << twin->baseline_preset << ", noise " << twin->noise_rms_N_m
            << " N/m\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  bool lists = false;
  CLI::App app("Synthetic captures with hidden effects of a known size", "tenter-twin");
  app.add_option("effects", options.twin_case.effects,
                 "Effects to hide, each 'id' or 'id:variant'; none for a null twin");
  app.add_option("--size", options.twin_case.size, "Size of each effect, in units of the noise")
      ->capture_default_str();
  app.add_option("--suite", options.twin_case.suite, "Protocol suite")->capture_default_str();
  app.add_option("--seed", options.twin_case.seed, "Seed of cloth, noise and variant")
      ->capture_default_str();
  app.add_option("--only", options.only, "Write only this capture of the suite, e.g. strip_x");
  app.add_option("--out", options.out,
                 "A .h5 file, or an existing folder for one file per capture");
  app.add_flag("--list", lists, "List the effects and suites");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  if (lists) {
    list();
    return 0;
  }
  if (options.out.empty())
    return fail({tenter::ErrorKind::bad_input, "--out FILE.h5 or --out FOLDER is needed"});
  return run(options);
}
