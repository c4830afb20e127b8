// SPDX-License-Identifier: GPL-3.0-or-later
// Screen of the whole catalogue on one capture against one more fit (CPU seconds, one thread).
//
// The capture has what the catalogue asks for: load cells by name, a clock, loops, points that are
// hidden now and then, a sheet that weighs something. "One more fit" is the cheapest that deserves
// the name: from stretch and shear a tenth beside the optimum, each frame starting at the
// first fit's rest.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

#include "common/model/presets.h"
#include "server/diagnosis/field/field_trial.h"
#include "server/diagnosis/field/screen/field_excitation.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "tests/bench/cpu_time.h"
#include "tests/twin/fabrics/sequences/fabric_model.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

using namespace tenter;

namespace {

constexpr int kExtended = 4;     // effects that are refitted
constexpr double kBeside = 0.1;  // where one more fit starts

/// Load cells get names, and in every fourth frame one point is not seen.
void name_and_hide(estimation::Sequence& sequence) {
  for (std::size_t k = 0; k < sequence.forces.size(); ++k)
    sequence.forces[k].name = "cell_" + std::to_string(k + 1);
  const Eigen::Index points = sequence.frames.front().points_m.cols();
  for (std::size_t f = 0; f < sequence.frames.size(); f += 4)
    sequence.frames[f].points_m.col(points / 2).setConstant(std::nan(""));
}

/// cloth_stvk with the bending of the fabric, which a picture frame does not show, and stretch and
/// shear as the preset has them.
model::Model start_of(const twin::Fabric& fabric) {
  model::Model cloth = model::preset("cloth_stvk").value();
  const model::Model truth = twin::fabric_model(fabric);
  for (std::size_t t = 0; t < cloth.terms.size(); ++t)
    if (cloth.terms[t].strain.name.starts_with("bend")) {
      cloth.terms[t].law = truth.terms[t].law;
      for (model::Parameter& p : cloth.terms[t].law.parameters) p.fixed = true;
    }
  return cloth;
}

}  // namespace

int main(int argc, char** argv) {
  const int nodes = argc > 1 ? std::atoi(argv[1]) : 25;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 40;
  const twin::Fabric fabric = twin::without_friction(twin::fabric(argc > 3 ? argv[3] : "12"));
  auto measured = twin::same_mesh_twin(
      fabric, twin::make_protocol(fabric, "shear", {.frames = frames, .cells = nodes - 1}),
      {.nodes = nodes});
  if (!measured) return std::fprintf(stderr, "%s\n", measured.error().message.c_str()), 1;
  twin::Random random(twin::stream_seed(1, "bench"));
  twin::add_rig_noise({}, random, measured->sequence);
  name_and_hide(measured->sequence);
  diagnosis::FieldData data;
  data.sequences = {measured->sequence};
  data.ids = data.protocols = {"bench"};
  data.has_clock = {true};
  for (auto& frame : data.sequences[0].frames) frame.duration_s = 1.0;

  const model::Model cloth = start_of(fabric);
  const double began = timing::thread_cpu_seconds();
  const auto first = diagnosis::fit_field(cloth, data, {}, {});
  const double fitted = timing::thread_cpu_seconds();
  if (!first) return std::fprintf(stderr, "%s\n", first.error().message.c_str()), 1;
  model::Model beside = first->at.model;
  for (model::Term& term : beside.terms)
    if (!term.strain.name.starts_with("bend")) term.law.parameters[0].value *= 1.0 + kBeside;
  const auto again = diagnosis::fit_field(beside, data, first->states, {});
  const double refitted = timing::thread_cpu_seconds();
  const auto excitation = diagnosis::examine_sheets(data, first->states);
  const double examined = timing::thread_cpu_seconds();
  if (!again) return std::fprintf(stderr, "%s\n", again.error().message.c_str()), 1;
  if (!excitation) return std::fprintf(stderr, "%s\n", excitation.error().message.c_str()), 1;
  const auto screen = diagnosis::screen_field(*first, data, *excitation, {}, 1);
  const double screened = timing::thread_cpu_seconds();
  if (!screen) return std::fprintf(stderr, "%s\n", screen.error().message.c_str()), 1;
  // what the chain does next: the likeliest of a few effects, each fitted with the model
  double extended_s = 0.0;
  int extended = 0, iterations = 0;
  std::set<std::string> seen;
  for (const diagnosis::Candidate& c : screen->candidates) {
    if (!seen.insert(c.effect->id).second || c.effect->kind != effects::Kind::material) continue;
    const double start = timing::thread_cpu_seconds();
    const auto trial = diagnosis::refit_field(c, *first, data, {});
    if (!trial.trial.fit.usable) continue;
    extended_s += timing::thread_cpu_seconds() - start;
    iterations += trial.trial.fit.iterations;
    if (++extended == kExtended) break;
  }
  int tried = 0;
  for (const diagnosis::ScreenRow& row : screen->table) {
    tried += row.status == "screened" ? 1 : 0;
    if (row.status != "screened")
      std::printf("not screened       %s: %s\n", row.effect->id.c_str(), row.status.c_str());
  }
  std::printf("%d x %d nodes, %d frames, %zu rows, %zu candidates of %d effects of %zu\n", nodes,
              nodes, frames, first->rows.size(), screen->candidates.size(), tried,
              screen->table.size());
  std::printf("first fit          %8.2f s  (%d iterations)\n", fitted - began,
              first->at.fit.iterations);
  std::printf("one more fit       %8.2f s  (%d iterations from %.0f %% beside, at rest there)\n",
              refitted - fitted, again->at.fit.iterations, 100.0 * kBeside);
  if (extended > 0)
    std::printf("one more with an effect %5.2f s  (%d iterations, mean of %d)\n",
                extended_s / extended, iterations / extended, extended);
  std::printf("what is excited    %8.2f s\n", examined - refitted);
  const double screen_s = screened - examined;
  std::printf("screen             %8.2f s  = %.2f of the first fit, %.2f of one more", screen_s,
              screen_s / (fitted - began), screen_s / (refitted - fitted));
  if (extended > 0)
    std::printf(", %.2f of one more with an effect", screen_s * extended / extended_s);
  std::printf("\n");
  return 0;
}
