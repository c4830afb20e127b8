// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/requests/sheet_samples.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "server/estimation/sequences/folds/meaningful_rows.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/jobs/sheet_fit/certainty/optimum.h"

namespace tenter::jobs {
namespace {

using estimation::MaterialSamples;
using estimation::ResidualFunction;
using estimation::Sequence;
using estimation::SequenceEvaluator;

std::vector<Sequence> thinned(std::vector<Sequence> sequences) {
  for (Sequence& sequence : sequences) {
    const int frames = static_cast<int>(sequence.frames.size());
    estimation::keep_frames(sequence, estimation::even_frames(frames, kSampleFrames));
  }
  return sequences;
}

/// Over the material of all sheets that are compared.
MaterialSamples samples_over(const std::vector<Sequence>& sequences) {
  Eigen::Vector2d low = sequences.front().cloth.mesh.material_m.col(0), high = low;
  for (const Sequence& sequence : sequences) {
    const auto& places = sequence.cloth.mesh.material_m;
    low = low.cwiseMin(places.rowwise().minCoeff());
    high = high.cwiseMax(places.rowwise().maxCoeff());
  }
  MaterialSamples samples =
      estimation::even_samples(kGrid, kGrid, high.x() - low.x(), high.y() - low.y());
  for (std::size_t i = 0; i < samples.field.positions_m.size(); ++i)
    samples.field.positions_m[i] += low[static_cast<Eigen::Index>(i % 2)];
  return samples;
}

estimation::MakeFor evaluators_of(const std::vector<Sequence>& sequences, const RequestWork& work) {
  return [&sequences,
          &work](const model::Model& model) -> Expected<std::unique_ptr<ResidualFunction>> {
    auto made = SequenceEvaluator::make(model, sequences, sequence_options(work));
    if (!made) return tl::unexpected(made.error());
    return std::make_unique<SequenceEvaluator>(std::move(*made));
  };
}

/// Parameters that share a number are told of once: among themselves they are the same.
void tell_once(const model::Model& model, const estimation::SampledFit& fit,
               estimation::FitResult& optimum) {
  std::optional<int> background;
  for (int k = 0; k < kGrid * kGrid; ++k) {
    if (std::find(fit.released.begin(), fit.released.end(), k) != fit.released.end()) continue;
    if (!background) {
      background = k;
      continue;
    }
    for (const int parameter : estimation::parameters_of_sample(model, k)) {
      optimum.correlation.row(parameter).setZero();
      optimum.correlation.col(parameter).setZero();
    }
  }
}

}  // namespace

Expected<SampledModel> sheet_samples(model::Model& model, const SheetFindings& found,
                                     const RequestWork& work) {
  const auto fitted = thinned(compared_sequences(found));
  const auto unseen = thinned(compared_sequences(found, FramesStart::at_rest, Compared::held_out));
  SampledModel result;
  if (fitted.empty() || unseen.empty()) {
    result.found.message =
        fitted.empty() ? "no fitted frame has a rest" : "no frame of a held-out capture has a rest";
    return result;
  }
  result.found.samples = samples_over(fitted);
  estimation::SampleOptions options;
  options.fit.method = estimation::FitMethod::bounded_marquardt;
  options.fit.max_iterations = 20;
  options.fit.tolerance = 1e-4;
  options.fit.on_iteration = [&](int iteration, double cost) {
    work.report({"samples", "", iteration, cost, work.fraction});
    return !work.stop.stop_requested();
  };
  options.most = found.options.samples;
  options.meaningful = [](const ResidualFunction& function) {
    return estimation::meaningful_rows(static_cast<const SequenceEvaluator&>(function));
  };
  auto sampled = estimation::add_samples(model, result.found.samples, evaluators_of(fitted, work),
                                         evaluators_of(unseen, work), options);
  if (work.stop.stop_requested()) return fail(ErrorKind::cancelled, "the fit was stopped");
  if (!sampled) {
    result.found.message = sampled.error().message;
    return result;
  }
  result.found.fit = std::move(*sampled);
  if (!result.found.fit.released.empty()) {
    model = result.found.fit.model;
    tell_once(model, result.found.fit, result.found.fit.fit);
    result.optimum = std::move(result.found.fit.fit);
  }
  result.found.fit.fit = {};
  return result;
}

}  // namespace tenter::jobs
