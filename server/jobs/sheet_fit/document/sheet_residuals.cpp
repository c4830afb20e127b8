// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/document/sheet_residuals.h"

#include <cmath>

#include "server/jobs/sheet_fit/document/clip_travel.h"

namespace tenter::jobs {
namespace {

using estimation::Sequence;

report::ResidualTable force_table(const SheetInput& input, std::size_t channel,
                                  const Prediction& before, const Prediction& after) {
  const Sequence& sequence = input.sequence();
  const estimation::ForceChannel& force = sequence.forces[channel];
  const auto clip = static_cast<std::size_t>(force.clip);
  const auto row = static_cast<Eigen::Index>(3 * sequence.points.size() + channel);
  report::ResidualTable table;
  table.capture_id = input.id;
  table.capture_title = input.capture.title;
  table.channel = sequence.boundaries.front().clips[clip].id;
  for (std::size_t k = 0; k < channel; ++k)
    if (sequence.forces[k].clip == force.clip)
      table.channel = sequence.boundaries.front().clips[clip].id + "_" + std::to_string(channel);
  table.unit = "N";
  table.displacement_m = clip_travel(sequence, clip).along_m;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const std::size_t captured = input.captured.frame[f];
    const auto at = static_cast<Eigen::Index>(f);
    table.frame.push_back(input.frame_number(f));
    table.run.push_back(
        input.capture.runs[static_cast<std::size_t>(input.capture.run[captured])].number);
    table.block.push_back(sequence.frames[f].block);
    table.branch.push_back(static_cast<int>(input.capture.branch[captured]));
    if (!input.capture.time_s.empty()) table.time_s.push_back(input.capture.time_s[captured]);
    for (std::vector<double>* strain : {&table.strain_x, &table.strain_y, &table.strain_xy})
      strain->push_back(std::nan(""));
    table.measured.push_back(sequence.frames[f].forces_N[static_cast<Eigen::Index>(channel)]);
    table.predicted_baseline.push_back(before.value(row, at));
    table.predicted_extended.push_back(after.value(row, at));
    table.sigma.push_back(force.sigma_N);
    table.weight.push_back(input.held_out || !after.states[f] ? 0.0 : sequence.weight);
  }
  return table;
}

}  // namespace

std::vector<report::ResidualTable> sheet_residual_tables(const SheetFindings& found) {
  std::vector<report::ResidualTable> tables;
  for (std::size_t i = 0; i < found.inputs.size(); ++i)
    for (std::size_t c = 0; c < found.inputs[i].sequence().forces.size(); ++c)
      tables.push_back(force_table(found.inputs[i], c, found.before[i], found.after[i]));
  return tables;
}

std::vector<report::VertexResiduals> sheet_vertex_residuals(const SheetFindings& found) {
  std::vector<report::VertexResiduals> blocks;
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    const SheetInput& input = found.inputs[i];
    const Sequence& sequence = input.sequence();
    if (sequence.points.empty()) continue;
    report::VertexResiduals block;
    block.capture_id = input.id;
    block.capture_title = input.capture.title;
    block.vertex = input.captured.vertex;
    for (const estimation::PointChannel& p : sequence.points) {
      block.material_m.insert(block.material_m.end(), {p.material_m[0], p.material_m[1]});
      block.sigma_m.push_back(p.sigma_m);
    }
    const auto coordinates = static_cast<Eigen::Index>(3 * sequence.points.size());
    for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
      block.frame.push_back(input.frame_number(f));
      const double* measured = sequence.frames[f].points_m.data();
      block.measured_m.insert(block.measured_m.end(), measured, measured + coordinates);
      for (const auto& [into, prediction] : {std::pair{&block.start_m, &found.before[i]},
                                             std::pair{&block.fitted_m, &found.after[i]}}) {
        const auto column = prediction->value.col(static_cast<Eigen::Index>(f));
        into->insert(into->end(), column.data(), column.data() + coordinates);
      }
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

}  // namespace tenter::jobs
