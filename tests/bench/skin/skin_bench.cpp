// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-skin FOLDER [THINNING]: a membrane fitted to skin in vivo, homogeneous, then with
// material samples; every other frame is held out. FOLDER holds the csv files of skin-invivo-dic.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "common/model/presets.h"
#include "server/estimation/heterogeneity/progressive_samples.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/bench/skin/skin_data.h"

namespace tenter::bench {
namespace {

using namespace estimation;

/// Orthotropic membrane that is convex whatever its stiffnesses are: the strains couple by their
/// sum. A bending stiffness that nothing fits holds the skin to its plane.
model::Model membrane() {
  model::Model model = model::preset("stvk_orthotropic").value();
  for (model::Term& term : model.terms) {
    if (term.id == "coupling") {
      term.strain.name = "green_trace";
      term.law = model.terms[0].law;
    }
    term.law.parameters[0].value = 20.0;
    term.law.parameters[0].lower = 1.0;  // a membrane without stiffness has no shape
  }
  const model::Model cloth = model::preset("cloth_stvk").value();
  for (model::Term term : cloth.terms)
    if (term.strain.name.starts_with("bend")) {
      term.law.parameters[0].value = 1e-2;
      term.law.parameters[0].fixed = true;
      model.terms.push_back(std::move(term));
    }
  return model;
}

Sequence with_frames(const Sequence& all, std::size_t first) {
  Sequence part = all;
  part.frames.clear();
  for (std::size_t f = first; f < all.frames.size(); f += 2) {
    part.frames.push_back(all.frames[f]);
    part.frames.back().block = static_cast<int>(part.frames.size()) - 1;
  }
  return part;
}

MakeFor evaluator_of(const Sequence& sequence) {
  return [&sequence](const model::Model& model) -> Expected<std::unique_ptr<ResidualFunction>> {
    SequenceOptions options;
    options.threads = 2;
    auto made = SequenceEvaluator::make(model, {sequence}, options);
    if (!made) return tl::unexpected(made.error());
    return std::make_unique<SequenceEvaluator>(std::move(*made));
  };
}

struct Errors {
  double along_mm = 0.0, across_mm = 0.0, force_mN = 0.0;
};
Errors errors_of(const model::Model& model, const Sequence& sequence) {
  auto made = evaluator_of(sequence)(model);
  Eigen::VectorXd r;
  Errors errors;
  if (!made || (*made)->evaluate(parameter_values(model), r, nullptr) != mechanics::PathStatus::ok)
    return errors;
  const auto& states = static_cast<SequenceEvaluator&>(**made).states()[0];
  const auto points = static_cast<double>(sequence.points.size() * states.size());
  // rows of a point are its two seen coordinates; forces come after all points of a frame
  const std::size_t per_frame = 2 * sequence.points.size() + 1;
  const std::vector<Row>& rows = (*made)->rows();
  std::vector<std::size_t> seen(states.size(), 0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t k = seen[static_cast<std::size_t>(rows[i].frame)]++;
    const double square = r[static_cast<Eigen::Index>(i)] * r[static_cast<Eigen::Index>(i)];
    if (k + 1 == per_frame)
      errors.force_mN +=
          square * std::pow(1e3 * kForceSigma_N, 2) / static_cast<double>(states.size());
    else
      (k % 2 == 0 ? errors.along_mm : errors.across_mm) +=
          square * std::pow(1e3 * kPointSigma_m, 2) / points;
  }
  return {std::sqrt(errors.along_mm), std::sqrt(errors.across_mm), std::sqrt(errors.force_mN)};
}

void print(const char* what, const model::Model& model, const Sequence& seen,
           const Sequence& unseen) {
  const Errors a = errors_of(model, seen);
  const Errors b = errors_of(model, unseen);
  std::printf("  %-14s fitted %.4f %.4f mm %.2f mN   held out %.4f %.4f mm %.2f mN\n", what,
              a.along_mm, a.across_mm, a.force_mN, b.along_mm, b.across_mm, b.force_mN);
}

int run(const std::string& folder, int thinning) {
  for (const bool edge_is_held : {true, false}) {
    const auto data = read_skin(folder, edge_is_held, thinning);
    if (!data) {
      std::fprintf(stderr, "%s\n", data.error().message.c_str());
      return 1;
    }
    const Sequence seen = with_frames(data->sequence, 1);
    const Sequence unseen = with_frames(data->sequence, 0);
    MaterialSamples samples = even_samples(4, 2, data->gap_m, 0.5 * data->gap_m);
    for (std::size_t i = 0; i < samples.field.positions_m.size(); i += 2) {
      samples.field.positions_m[i] += data->between_m.x();
      samples.field.positions_m[i + 1] += data->between_m.y() - 0.25 * data->gap_m;
    }
    samples.terms = {"weft", "warp", "coupling", "shear"};
    std::printf(
        "edge of the patch %s; %zu points, %zu frames fitted, %zu held out; errors: along, "
        "across, force\n",
        edge_is_held ? "held" : "free", seen.points.size(), seen.frames.size(),
        unseen.frames.size());
    SampleOptions options;
    options.fit.tolerance = 1e-5;
    options.most = 3;
    options.fit.max_iterations = 40;
    const auto start = std::chrono::steady_clock::now();
    model::Model plain = membrane();
    auto evaluator = evaluator_of(seen)(plain);
    if (!evaluator) {
      std::fprintf(stderr, "%s\n", evaluator.error().message.c_str());
      return 1;
    }
    store(fit(**evaluator, plain, options.fit), plain);
    const auto found =
        add_samples(plain, samples, evaluator_of(seen), evaluator_of(unseen), options);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!found) {
      std::fprintf(stderr, "%s\n", found.error().message.c_str());
      return 1;
    }
    print("homogeneous", plain, seen, unseen);
    std::printf("    ");
    for (std::size_t t = 0; t < 4; ++t)
      std::printf("%s %.3g N/m  ", plain.terms[t].id.c_str(),
                  plain.terms[t].law.parameters[0].value);
    std::printf("\n");
    print("heterogeneous", found->model, seen, unseen);
    for (const SampleStep& step : found->steps)
      std::printf(
          "    sample at (%.1f, %.1f) mm: gain foreseen %.3g, held-out cost %.4g (%.1f "
          "sigmas), %s\n",
          1e3 * samples.field.positions_m[static_cast<std::size_t>(2 * step.sample)],
          1e3 * samples.field.positions_m[static_cast<std::size_t>(2 * step.sample + 1)], step.gain,
          step.held_out, step.sigmas, step.kept ? "kept" : "put back");
    std::printf("    held-out cost %.4g homogeneous, %.4g with %zu samples; %.1f s in all\n",
                found->homogeneous_held_out, found->held_out, found->released.size(), seconds);
  }
  return 0;
}

}  // namespace
}  // namespace tenter::bench

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc < 2) {
    std::fprintf(stderr, "tenter-bench-skin FOLDER [THINNING]\n");
    return 2;
  }
  return tenter::bench::run(argv[1], argc > 2 ? std::max(1, std::atoi(argv[2])) : 3);
}
