// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/sheet_input.h"

#include <algorithm>
#include <utility>

#include "common/model/catalogue.h"
#include "server/estimation/staged/refit/grid_free_fit.h"

namespace tenter::jobs {
namespace {

Expected<estimation::Sequence> on_finer_grid(const SheetInput& input,
                                             estimation::FromCaptureOptions how) {
  how.nodes_u = 2 * (how.nodes_u - 1) + 1;
  auto finer = estimation::sequence_from_capture(input.capture, how);
  if (!finer)
    return fail(finer.error().kind,
                "options.without_grid_error: on the finer grid " + finer.error().message);
  finer->sequence.name = input.captured.sequence.name;
  estimation::measure_as(input.captured.sequence, finer->sequence);
  return std::move(finer->sequence);
}

}  // namespace

Expected<std::vector<SheetInput>> sheet_inputs(
    std::vector<std::pair<std::string, capture::Capture>> captures,
    const SheetFitOptions& options) {
  estimation::FromCaptureOptions how;
  how.nodes_u = options.resolution;
  how.is_graded = options.has_graded_grid;
  how.most_points = options.points;
  how.most_frames = options.frames;
  how.unknown_sigma_m = options.sigma_m;
  how.unknown_sigma_N = options.sigma_N;
  std::vector<SheetInput> inputs;
  for (auto& [id, capture] : captures) {
    auto captured = estimation::sequence_from_capture(capture, how);
    if (!captured)
      return fail(captured.error().kind, "capture \"" + capture.title + "\" (" + id.substr(0, 12) +
                                             "): " + captured.error().message);
    SheetInput input{id,
                     std::move(capture),
                     options.role_of(id),
                     options.is_held_out(id),
                     std::move(*captured),
                     std::nullopt};
    input.captured.sequence.name = input.capture.title;
    if (const auto weight = options.weights.find(id); weight != options.weights.end())
      input.captured.sequence.weight = weight->second;
    if (options.without_grid_error) {
      auto finer = on_finer_grid(input, how);
      if (!finer) return tl::unexpected(finer.error());
      input.finer = std::move(*finer);
    }
    input.capture.sheet->position_m = {};
    inputs.push_back(std::move(input));
  }
  return inputs;
}

Expected<std::vector<Prediction>> predictions(const model::Model& model,
                                              const std::vector<SheetInput>& inputs, int threads,
                                              const std::stop_token& stop) {
  std::vector<Prediction> all;
  for (const SheetInput& input : inputs) {
    if (stop.stop_requested())
      return fail(ErrorKind::cancelled, "stopped while models were compared");
    auto one = predict(model, input.sequence(), threads);
    if (!one) return fail(one.error().kind, input.capture.title + ": " + one.error().message);
    all.push_back(std::move(*one));
  }
  return all;
}

bool has_springs(const model::Model& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const model::Term& term) {
    const auto* strain = model::find_strain(term.strain.name);
    return strain != nullptr && strain->domain == model::Domain::edge;
  });
}

}  // namespace tenter::jobs
