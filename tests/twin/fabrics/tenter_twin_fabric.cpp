// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-twin-fabric: writes the seven captures of a twin fabric, as the rig would have made them.
//
//   tenter-twin-fabric 18 --out wool --nodes 13 --frames 12
//   tenter-twin-fabric 14 --out denim --independent --friction --cords 0.1
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "tests/twin/fabrics/sequences/capture_of.h"
#include "tests/twin/fabrics/sequences/cross_twin.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

namespace {

using namespace tenter;

struct Options {
  std::string fabric;
  std::filesystem::path folder;
  std::vector<std::string> only;
  int nodes = 25;
  int frames = 20;
  bool is_independent = false;
  bool has_friction = false;
  double cord_loop_N = 0.0;
  std::uint64_t seed = 1;
};

Expected<estimation::Sequence> measured(const twin::Fabric& cloth, const twin::Protocol& protocol,
                                        const Options& options) {
  if (options.is_independent) {
    twin::CrossOptions how;
    how.grid.nodes = options.nodes;
    auto made = twin::cross_twin(cloth, protocol, how);
    if (!made) return tl::unexpected(made.error());
    return std::move(made->sequence);
  }
  auto made = twin::same_mesh_twin(cloth, protocol, {.nodes = options.nodes});
  if (!made) return tl::unexpected(made.error());
  return std::move(made->sequence);
}

int fail(const Error& error) {
  std::cerr << "tenter-twin-fabric: " << error.message << "\n";
  return static_cast<int>(error.kind);
}

int run(const Options& options) {
  std::error_code problem;
  std::filesystem::create_directories(options.folder, problem);
  if (problem)
    return fail(
        {ErrorKind::bad_input, options.folder.string() + " cannot be made: " + problem.message()});
  twin::Fabric cloth = twin::fabric(options.fabric);
  if (!options.has_friction) cloth = twin::without_friction(std::move(cloth));
  twin::Random random(twin::stream_seed(options.seed, "rig"));
  for (const std::string& name : options.only.empty() ? twin::protocol_names() : options.only) {
    const twin::Protocol protocol =
        twin::make_protocol(cloth, name, {.frames = options.frames, .cells = options.nodes - 1});
    auto sequence = measured(cloth, protocol, options);
    if (!sequence) return fail(sequence.error());
    twin::add_rig_noise({.cord_loop_N = options.cord_loop_N}, random, *sequence);
    const std::string path = (options.folder / (name + ".h5")).string();
    const auto written = capture::write_capture(twin::capture_of(cloth, protocol, *sequence), path);
    if (!written) return fail(written.error());
    std::cout << path << "\n" << std::flush;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Writes the captures of a twin fabric (synthetic) in the rig's seven sequences."};
  Options options;
  app.add_option("fabric", options.fabric, "4, 12, 14, 18, or a second specimen: 4.2, ...")
      ->required()
      ->check(CLI::IsMember(twin::fabric_ids()));
  app.add_option("--out", options.folder, "folder for the captures")->required();
  app.add_option("--only", options.only, "these sequences, not all seven")
      ->check(CLI::IsMember(twin::protocol_names()));
  app.add_option("--nodes", options.nodes, "grid of the sheet, nodes a side (25)")
      ->check(CLI::Range(7, 101));
  app.add_option("--frames", options.frames, "of each sequence (20)")->check(CLI::Range(4, 200));
  app.add_flag("--independent", options.is_independent,
               "from a smooth sheet that shares nothing with the fit, seen at irregular places");
  app.add_flag("--friction", options.has_friction, "with the fabric's loops; needs --independent");
  app.add_option("--cords", options.cord_loop_N, "loop of the cords over their pulleys (0 N)")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--seed", options.seed, "of the noise (1)");
  CLI11_PARSE(app, argc, argv);
  if (options.has_friction && !options.is_independent)
    return fail({ErrorKind::bad_input, "--friction needs --independent"});
  return run(options);
}
