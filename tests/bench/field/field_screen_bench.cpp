// SPDX-License-Identifier: GPL-3.0-or-later
// Screen of the whole catalogue on one capture against one more fit (CPU seconds, one thread).
#include <cstdio>
#include <cstdlib>

#include "common/model/presets.h"
#include "server/diagnosis/field/screen/field_excitation.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "tests/bench/cpu_time.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

using namespace tenter;

int main(int argc, char** argv) {
  const int nodes = argc > 1 ? std::atoi(argv[1]) : 25;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 40;
  const twin::Fabric fabric = twin::without_friction(twin::fabric("12"));
  auto measured = twin::same_mesh_twin(
      fabric, twin::make_protocol(fabric, "stretch_v", {.frames = frames, .cells = nodes - 1}),
      {.nodes = nodes});
  if (!measured) return std::fprintf(stderr, "%s\n", measured.error().message.c_str()), 1;
  twin::Random random(twin::stream_seed(1, "bench"));
  twin::add_rig_noise({}, random, measured->sequence);
  diagnosis::FieldData data;
  data.sequences = {measured->sequence};
  data.ids = data.protocols = {"bench"};
  data.has_clock = {false};
  for (auto& frame : data.sequences[0].frames) frame.duration_s = 1.0;

  const model::Model cloth = model::preset("cloth_stvk").value();
  const double began = timing::thread_cpu_seconds();
  const auto first = diagnosis::fit_field(cloth, data, {}, {});
  const double fitted = timing::thread_cpu_seconds();
  if (!first) return std::fprintf(stderr, "%s\n", first.error().message.c_str()), 1;
  // from a tenth beside the optimum, at rest there: the cheapest fit that deserves the name
  model::Model beside = first->at.model;
  for (model::Term& term : beside.terms) term.law.parameters[0].value *= 1.1;
  const auto again = diagnosis::fit_field(beside, data, first->states, {});
  const double refitted = timing::thread_cpu_seconds();
  const auto excitation = diagnosis::examine_sheets(data, first->states);
  const double examined = timing::thread_cpu_seconds();
  if (!again || !excitation) return 1;
  const auto screen = diagnosis::screen_field(*first, data, *excitation, {}, 1);
  const double screened = timing::thread_cpu_seconds();
  if (!screen) return std::fprintf(stderr, "%s\n", screen.error().message.c_str()), 1;
  std::printf("%d x %d nodes, %d frames, %zu rows, %zu candidates of %zu effects\n", nodes, nodes,
              frames, first->rows.size(), screen->candidates.size(), screen->table.size());
  std::printf("first fit          %8.2f s  (%d iterations)\n", fitted - began,
              first->at.fit.iterations);
  std::printf("one more fit       %8.2f s  (%d iterations)\n", refitted - fitted,
              again->at.fit.iterations);
  std::printf("what is excited    %8.2f s\n", examined - refitted);
  std::printf("screen             %8.2f s  = %.2f of the first fit, %.2f of one more\n",
              screened - examined, (screened - examined) / (fitted - began),
              (screened - examined) / (refitted - fitted));
  return 0;
}
