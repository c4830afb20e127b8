// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/document/sheet_figures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/estimation/sequences/material/material_locator.h"
#include "server/jobs/sheet_fit/document/clip_travel.h"
#include "server/jobs/sheet_fit/document/sheet_residuals.h"

namespace tenter::jobs {
namespace {

using estimation::ObservationKind;
using estimation::Sequence;
using nlohmann::json;

constexpr std::size_t kMostArrows = 150;

/// To a tenth of a micrometre: what a picture shows, in short numbers.
double shown(double length_m) {
  const double rounded = std::round(length_m * 1e7) / 1e7;
  return rounded == 0.0 ? 0.0 : rounded;
}

json point(const Eigen::Vector3d& p) {
  return {shown(p[0]), shown(p[1]), shown(p[2])};
}

json series(const report::ResidualTable& table, int block, const char* role,
            const std::vector<double>& values) {
  json x = json::array(), y = json::array();
  std::string branch;
  for (std::size_t r = 0; r < table.size(); ++r) {
    if (table.block[r] != block || !std::isfinite(values[r])) continue;
    branch = report::branch_word(table.branch[r]);
    x.push_back(table.displacement_m[r]);
    y.push_back(values[r]);
  }
  return {{"name", std::string(role) + ", block " + std::to_string(block + 1)},
          {"role", role},
          {"block", block},
          {"branch", branch},
          {"x", x},
          {"y", y}};
}

json loop(const report::ResidualTable& table, const std::string& travel) {
  json all = json::array();
  const int blocks =
      table.block.empty() ? 0 : 1 + *std::max_element(table.block.begin(), table.block.end());
  for (int block = 0; block < blocks; ++block)
    for (const auto& [role, values] :
         {std::pair{"measured", &table.measured}, std::pair{"baseline", &table.predicted_baseline},
          std::pair{"extended", &table.predicted_extended}}) {
      json one = series(table, block, role, *values);
      if (!one["x"].empty()) all.push_back(std::move(one));
    }
  return {{"kind", "loop"},
          {"capture", table.capture_id},
          {"title", "Force, " + table.channel},
          {"x", {{"name", travel}, {"unit", "m"}}},
          {"y", {{"name", "force"}, {"unit", "N"}}},
          {"series", all}};
}

json position_errors(const SheetFindings& found, std::size_t i) {
  const SheetInput& input = found.inputs[i];
  json all = json::array();
  for (const auto& [role, prediction] :
       {std::pair{"baseline", &found.before[i]}, std::pair{"extended", &found.after[i]}}) {
    json x = json::array(), y = json::array();
    for (std::size_t f = 0; f < input.sequence().frames.size(); ++f) {
      const Misfit of = misfit(input.sequence(), *prediction, ObservationKind::position, f);
      if (of.rows == 0) continue;
      x.push_back(input.frame_number(f));
      y.push_back(std::sqrt(of.square / of.rows));
    }
    if (!x.empty()) all.push_back({{"name", ""}, {"role", role}, {"x", x}, {"y", y}});
  }
  if (all.empty()) return nullptr;
  return {{"kind", "position_error"},
          {"capture", input.id},
          {"title", "Position error"},
          {"x", {{"name", "frame"}, {"unit", "1"}}},
          {"y", {{"name", "rms of a coordinate"}, {"unit", "m"}}},
          {"series", all}};
}

/// The sheet of one frame, its residuals spread from the points to the nodes about them.
class MeshPicture {
 public:
  MeshPicture(const SheetInput& input, const Prediction& after)
      : input_(input), after_(after), sequence_(input.sequence()) {
    const estimation::MaterialLocator locator(sequence_.cloth.mesh);
    for (const estimation::PointChannel& p : sequence_.points)
      places_.push_back(locator.locate(p.material_m).value_or(estimation::MaterialLocation{}));
  }

  /// Frames of the sequence with the word why; none where nothing was compared.
  std::vector<std::pair<std::size_t, std::string>> frames() const {
    std::optional<std::size_t> farthest, worst;
    double most_moved = -1.0, most_missed = -1.0;
    const mechanics::State* first = nullptr;
    for (std::size_t f = 0; f < sequence_.frames.size(); ++f) {
      if (!after_.states[f]) continue;
      if (first == nullptr) first = &*after_.states[f];
      const double moved = (after_.states[f]->x - first->x).norm();
      const Misfit of = misfit(sequence_, after_, ObservationKind::position, f);
      const double missed = of.rows > 0 ? of.square / of.rows : -1.0;
      if (moved > most_moved) {
        most_moved = moved;
        farthest = f;
      }
      if (missed > most_missed) {
        most_missed = missed;
        worst = f;
      }
    }
    std::vector<std::pair<std::size_t, std::string>> chosen;
    if (farthest) chosen.emplace_back(*farthest, "largest displacement");
    if (worst && worst != farthest) chosen.emplace_back(*worst, "worst residual");
    if (worst && worst == farthest) chosen.back().second += ", worst residual";
    return chosen;
  }

  json picture(std::size_t frame, const std::string& why) const {
    const mechanics::State& state = *after_.states[frame];
    const auto nodes = static_cast<std::size_t>(sequence_.cloth.mesh.node_count());
    std::vector<double> sum(nodes, 0.0), weight(nodes, 0.0);
    json arrows = json::array();
    double sigma_square = 0.0;
    const std::size_t step = std::max<std::size_t>(1, places_.size() / kMostArrows);
    for (std::size_t k = 0; k < places_.size(); ++k) {
      sigma_square += std::pow(sequence_.points[k].sigma_m, 2);
      const auto left = residual(frame, k);
      if (!left) continue;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto node = static_cast<std::size_t>(places_[k].nodes[a]);
        sum[node] += places_[k].weight[a] * left->norm();
        weight[node] += places_[k].weight[a];
      }
      if (k % step == 0)
        arrows.push_back(
            {{"at_m", point(places_[k].position(state.x))}, {"residual_m", point(*left)}});
    }
    json positions = json::array(), residuals = json::array();
    for (std::size_t n = 0; n < nodes; ++n) {
      positions.push_back(point(state.x.segment<3>(static_cast<Eigen::Index>(3 * n))));
      residuals.push_back(weight[n] > 1e-6 ? json(shown(sum[n] / weight[n])) : json(nullptr));
    }
    const Misfit of = misfit(sequence_, after_, ObservationKind::position, frame);
    return {{"capture", input_.id},
            {"title", input_.capture.title},
            {"frame", input_.frame_number(frame)},
            {"why", why},
            {"triangles", sequence_.cloth.mesh.triangles},
            {"position_m", positions},
            {"residual_m", residuals},
            {"sigma_m", places_.empty()
                            ? json(nullptr)
                            : json(std::sqrt(sigma_square / static_cast<double>(places_.size())))},
            {"arrows", arrows},
            {"rms_m", of.rows > 0 ? json(std::sqrt(of.square / of.rows)) : json(nullptr)}};
  }

 private:
  /// Measured minus model over the coordinates that were seen; none where none was.
  std::optional<Eigen::Vector3d> residual(std::size_t frame, std::size_t k) const {
    const auto column = static_cast<Eigen::Index>(k);
    const auto f = static_cast<Eigen::Index>(frame);
    Eigen::Vector3d left = Eigen::Vector3d::Zero();
    bool is_seen = false;
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double d =
          sequence_.frames[frame].points_m(c, column) - after_.value(3 * column + c, f);
      if (!std::isfinite(d)) continue;
      left[c] = d;
      is_seen = true;
    }
    return is_seen ? std::optional(left) : std::nullopt;
  }

  const SheetInput& input_;
  const Prediction& after_;
  const Sequence& sequence_;
  std::vector<estimation::MaterialLocation> places_;
};

}  // namespace

json sheet_figures(const SheetFindings& found) {
  json list = json::array();
  const std::vector<report::ResidualTable> tables = sheet_residual_tables(found);
  auto table = tables.begin();
  for (const SheetInput& input : found.inputs)
    for (const estimation::ForceChannel& force : input.sequence().forces) {
      const auto clip = static_cast<std::size_t>(force.clip);
      json figure = loop(*table++, clip_travel(input.sequence(), clip).words);
      if (!figure["series"].empty()) list.push_back(std::move(figure));
    }
  for (std::size_t i = 0; i < found.inputs.size(); ++i)
    if (json figure = position_errors(found, i); !figure.is_null())
      list.push_back(std::move(figure));
  return list;
}

json sheet_meshes(const SheetFindings& found) {
  json list = json::array();
  for (std::size_t i = 0; i < found.inputs.size(); ++i) {
    const MeshPicture meshes(found.inputs[i], found.after[i]);
    for (const auto& [frame, why] : meshes.frames()) list.push_back(meshes.picture(frame, why));
  }
  return list;
}

}  // namespace tenter::jobs
