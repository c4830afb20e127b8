// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/staged/twin_rig.h"

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "tests/twin/fabrics/protocols.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"
#include "tests/twin/random.h"

namespace tenter::bench {
namespace {

using estimation::Role;
using estimation::RoleSequence;

constexpr int kFewestNodes = 7;  // a side, that the protocols' clips find their lines

/// What the generator would abort on is said here, before anything is made.
void refuse_what_cannot_be(const RigSettings& settings) {
  if (settings.nodes >= kFewestNodes && settings.frames >= 1) return;
  if (settings.nodes < kFewestNodes)
    std::fprintf(stderr,
                 "--nodes=%d: the clips of the sequences need a grid of at least %d x %d nodes\n",
                 settings.nodes, kFewestNodes, kFewestNodes);
  else
    std::fprintf(stderr, "--frames=%d: a sequence has at least one frame\n", settings.frames);
  std::exit(1);
}

RoleSequence measured(const twin::Fabric& fabric, const std::string& protocol, Role role,
                      const RigSettings& settings) {
  twin::GridOptions grid;
  grid.nodes = settings.nodes;
  auto twin = twin::same_mesh_twin(
      fabric, twin::make_protocol(fabric, protocol, {settings.frames, settings.nodes - 1}), grid);
  if (!twin) {
    std::fprintf(stderr, "%s of #%s: %s\n", protocol.c_str(), fabric.id.c_str(),
                 twin.error().message.c_str());
    std::exit(1);
  }
  twin::Random random(twin::stream_seed(settings.seed, fabric.id + protocol));
  add_rig_noise({true, settings.cord_loop_N}, random, twin->sequence);
  return {role, std::move(twin->sequence)};
}

std::vector<RoleSequence> all(const std::string& id,
                              const std::vector<std::pair<std::string, Role>>& protocols,
                              const RigSettings& settings) {
  refuse_what_cannot_be(settings);
  std::vector<RoleSequence> sequences;
  sequences.reserve(protocols.size());
  for (const auto& [protocol, role] : protocols)
    sequences.push_back(measured(twin::fabric(id), protocol, role, settings));
  return sequences;
}

}  // namespace

std::vector<RoleSequence> fitting_sequences(const std::string& fabric,
                                            const RigSettings& settings) {
  return all(fabric,
             {{"stretch_u", Role::stretch_u},
              {"stretch_v", Role::stretch_v},
              {"shear", Role::shear},
              {"bend_u", Role::bend_u},
              {"bend_v", Role::bend_v}},
             settings);
}

std::vector<RoleSequence> evaluation_sequences(const std::string& fabric,
                                               const RigSettings& settings) {
  return all(fabric, {{"complex_shear", Role::evaluation}, {"corner_pull", Role::evaluation}},
             settings);
}

double peak_memory_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void add_rig_options(CLI::App& app, RigSettings& settings) {
  app.add_option("--nodes", settings.nodes, "Nodes on a side of the sheet.")
      ->check(CLI::Range(7, 201))
      ->capture_default_str();
  app.add_option("--frames", settings.frames, "Frames of a sequence.")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--cord", settings.cord_loop_N, "Hysteresis of the cords, N (0.1 in the thesis).")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

}  // namespace tenter::bench
