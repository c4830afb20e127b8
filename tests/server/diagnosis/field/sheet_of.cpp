// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/diagnosis/field/sheet_of.h"

#include <gtest/gtest.h>

#include <utility>

#include "common/model/presets.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/estimation/prediction.h"
#include "server/estimation/sequences/material/material_locator.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/twin/fabrics/sequences/rig_noise.h"
#include "tests/twin/fabrics/sequences/sequence_of.h"

namespace tenter::testing {
namespace {

/// Pulled a little further than noise, not so far that the measures of strain part.
twin::Fabric small_fabric() {
  twin::Fabric fabric = twin::fabric("12");
  fabric.limits = {0.08, 0.08, 0.1, 0.03, 0.03, 0.1, 4e-3};
  return fabric;
}

/// What the truth shows on every channel.
void measure(const model::Model& truth, estimation::Sequence& sequence) {
  for (auto& frame : sequence.frames) {
    frame.points_m.setZero();
    frame.forces_N.setZero();
  }
  auto evaluator = estimation::SequenceEvaluator::make(truth, {sequence});
  ASSERT_TRUE(evaluator) << evaluator.error().message;
  Eigen::VectorXd residuals;
  ASSERT_EQ(evaluator->evaluate(estimation::parameter_values(truth), residuals, nullptr),
            mechanics::PathStatus::ok)
      << evaluator->failure();
  const auto points = static_cast<Eigen::Index>(3 * sequence.points.size());
  for (std::size_t r = 0; r < evaluator->rows().size(); ++r) {
    const estimation::Row& row = evaluator->rows()[r];
    auto& frame = sequence.frames[static_cast<std::size_t>(row.frame)];
    const double x = residuals[static_cast<Eigen::Index>(r)];
    if (row.channel < points)
      frame.points_m.data()[row.channel] =
          x * sequence.points[static_cast<std::size_t>(row.channel / 3)].sigma_m;
    else
      frame.forces_N[row.channel - points] =
          x * sequence.forces[static_cast<std::size_t>(row.channel - points)].sigma_N;
  }
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    sequence.frames[f].start = evaluator->states()[0][f];
}

/// The protocol on a grid of `times` cells for one, seen at the nodes of the coarse one.
estimation::Sequence on_grid(const twin::Protocol& protocol, const SheetTruth& truth, int times) {
  twin::GridOptions grid;
  grid.nodes = truth.cells + 1;
  const auto coarse = twin::sequence_of(small_fabric(), protocol, grid);
  for (const auto& point : coarse.points) grid.points_m.push_back(point.material_m);
  grid.nodes = times * truth.cells + 1;
  grid.force_sigma_N *= truth.load_cells;
  estimation::Sequence sequence = twin::sequence_of(small_fabric(), protocol, grid);
  for (std::size_t k = 0; k < sequence.forces.size(); ++k)
    sequence.forces[k].name = protocol.name + "_" + std::to_string(k + 1);
  if (truth.two_rates)
    for (std::size_t f = 1; f < sequence.frames.size(); ++f)
      sequence.frames[f].duration_s = sequence.frames[f].block < 2 ? 1.0 : 10.0;
  return sequence;
}

/// What `from` measured, on another grid: each frame starts where that one came to rest.
void take_measured(const estimation::Sequence& from, estimation::Sequence& to) {
  const estimation::MaterialLocator locator(from.cloth.mesh);
  for (std::size_t f = 0; f < to.frames.size(); ++f) {
    estimation::SequenceFrame& frame = to.frames[f];
    frame.points_m = from.frames[f].points_m;
    frame.forces_N = from.frames[f].forces_N;
    mechanics::State start = *from.frames[f].start;
    start.x.resize(3 * static_cast<Eigen::Index>(to.cloth.mesh.node_count()));
    for (Eigen::Index n = 0; n < to.cloth.mesh.node_count(); ++n)
      start.x.segment<3>(3 * n) =
          locator.locate(to.cloth.mesh.material_m.col(n))->position(from.frames[f].start->x);
    frame.start = std::move(start);
  }
}

}  // namespace

model::Model compliant_cloth() {
  model::Model model = model::preset("cloth_stvk").value();
  const double k[] = {60.0, 40.0, 20.0, 8e-6, 8e-6, 5e-6};
  for (std::size_t t = 0; t < model.terms.size(); ++t)
    model.terms[t].law.parameters.front().value = k[t];
  return model;
}

diagnosis::SheetRequest sheets_of(const SheetTruth& truth, const model::Model& baseline) {
  diagnosis::SheetRequest request;
  request.model = baseline;
  const twin::Fabric fabric = small_fabric();
  for (const std::string& name : truth.protocols) {
    const twin::Protocol protocol =
        twin::make_protocol(fabric, name, {.frames = truth.frames, .cells = truth.cells});
    estimation::Sequence true_one = on_grid(protocol, truth, truth.fineness);
    if (truth.otherwise) truth.otherwise(true_one);
    measure(truth.model, true_one);
    estimation::Sequence sequence = on_grid(protocol, truth, truth.fit_fineness);
    take_measured(true_one, sequence);
    twin::Random random(twin::stream_seed(truth.seed, name));
    const auto scale = [&](double factor) {
      for (auto& point : sequence.points) point.sigma_m *= factor;
      for (auto& force : sequence.forces) force.sigma_N *= factor;
    };
    scale(truth.noise);
    twin::add_rig_noise({}, random, sequence);
    scale(1.0 / truth.noise);
    request.sequences.push_back(
        {"sha-" + name, name, estimation::Role::evaluation, std::move(sequence)});
    if (!truth.has_finer) continue;
    estimation::Sequence finer = on_grid(protocol, truth, 2 * truth.fit_fineness);
    take_measured(true_one, finer);
    for (std::size_t f = 0; f < finer.frames.size(); ++f) {  // with the noise
      finer.frames[f].points_m = request.sequences.back().sequence.frames[f].points_m;
      finer.frames[f].forces_N = request.sequences.back().sequence.frames[f].forces_N;
    }
    request.sequences.back().finer = std::move(finer);
  }
  return request;
}

diagnosis::FieldData data_of(const diagnosis::SheetRequest& request) {
  diagnosis::FieldData data;
  for (const diagnosis::SheetSequence& s : request.sequences) {
    data.sequences.push_back(s.sequence);
    for (auto& frame : data.sequences.back().frames) frame.duration_s = 1.0;
    data.ids.push_back(s.id);
    data.protocols.push_back(s.title);
    data.has_clock.push_back(false);
  }
  return data;
}

diagnosis::SheetDiagnosis diagnosed(const diagnosis::SheetRequest& request, int threads) {
  diagnosis::Control control;
  control.threads = threads;
  auto found = diagnosis::diagnose_sheets(request, control);
  EXPECT_TRUE(found) << (found ? "" : found.error().message);
  return found ? std::move(*found) : diagnosis::SheetDiagnosis{};
}

const diagnosis::Verdict& first(const diagnosis::SheetDiagnosis& d) {
  static const diagnosis::Verdict none;
  EXPECT_FALSE(d.verdicts.empty());
  return d.verdicts.empty() ? none : d.verdicts.front();
}

std::string in_lines(const std::vector<diagnosis::Verdict>& verdicts) {
  std::string lines;
  for (const diagnosis::Verdict& v : verdicts) {
    lines += std::string(diagnosis::verdict_name(v.kind)) + " " + v.effect + ": " + v.words;
    for (const std::string& other : v.alternatives) lines += " | " + other;
    lines += "\n";
  }
  return lines;
}

std::string in_lines(const diagnosis::SheetDiagnosis& d) {
  std::string lines = in_lines(d.verdicts);
  for (const diagnosis::PathStep& step : d.path)
    lines += "  " + step.action + " " + step.effect + ": " + step.why +
             ", chi2 = " + std::to_string(step.chi2) + "\n";
  for (std::size_t k = 0; k < d.first_screen.table.size() && k < 5; ++k) {
    const diagnosis::ScreenRow& row = d.first_screen.table[k];
    lines += "  screen " + row.effect->id + ": " + std::to_string(row.ratio) + "\n";
  }
  lines += "  lack of fit " + std::to_string(d.first_screen.lack_of_fit) + ", expected chi2 " +
           std::to_string(d.first_screen.expected_chi2) + "\n";
  for (const auto& item : d.checklist)
    lines += "  " + item.level + " " + item.what + ": " + item.why + "\n";
  return lines;
}

}  // namespace tenter::testing
