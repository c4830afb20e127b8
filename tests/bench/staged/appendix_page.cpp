// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/staged/appendix_page.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/report/html_report.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::bench {
namespace {

using estimation::ObservationKind;
using estimation::Role;
using estimation::Sequence;
using nlohmann::json;

/// A sequence with what a model shows on it.
class Shown {
 public:
  Shown(std::string id, Role role, const Sequence& sequence, estimation::RestingFrames found)
      : id_(std::move(id)),
        role_(role),
        sequence_(sequence),
        channels_(sequence),
        found_(std::move(found)) {}

  /// Of the force that changes most, over the way of the clip that goes farthest; null without one.
  json loop() const {
    int most = -1;
    double widest = 0.0;
    for (int c = 0; c < channels_.count(); ++c) {
      if (channels_.kind(sequence_, c) != ObservationKind::force) continue;
      double lo = 1e300, hi = -1e300;
      for (const int f : found_.resting) {
        const double value = channels_.measured(frame(f), c);
        lo = std::min(lo, value);
        hi = std::max(hi, value);
      }
      if (hi - lo > widest) {
        widest = hi - lo;
        most = c;
      }
    }
    if (most < 0) return nullptr;
    json x = json::array(), measured = json::array(), model = json::array();
    for (std::size_t k = 0; k < found_.resting.size(); ++k) {
      x.push_back(way_m(found_.resting[k]));
      measured.push_back(channels_.measured(frame(found_.resting[k]), most));
      model.push_back(value(k, most));
    }
    return figure("loop", "Force", {"displacement of the clip", "m"}, {"force", "N"}, x, measured,
                  x, model);
  }

  /// Height over the way along the middle of the strip in the last frame; null without points.
  json profile() const {
    const int along = role_ == Role::bend_v ? 1 : 0;
    double lo = 1e300, hi = -1e300;
    for (const auto& p : sequence_.points) {
      lo = std::min(lo, p.material_m[1 - along]);
      hi = std::max(hi, p.material_m[1 - along]);
    }
    double nearest = 1e300;
    for (const auto& p : sequence_.points)
      nearest = std::min(nearest, std::abs(p.material_m[1 - along] - 0.5 * (lo + hi)));
    std::vector<std::pair<double, int>> line;
    for (std::size_t p = 0; p < sequence_.points.size(); ++p) {
      const Eigen::Vector2d at = sequence_.points[p].material_m;
      if (std::abs(at[1 - along] - 0.5 * (lo + hi)) <= nearest + 1e-9)
        line.emplace_back(at[along], static_cast<int>(p));
    }
    if (line.empty()) return nullptr;
    std::sort(line.begin(), line.end());
    const std::size_t last = found_.resting.size() - 1;
    const auto measured_at = [&](int point, int axis) {
      return channels_.measured(frame(found_.resting[last]), 3 * point + axis);
    };
    json x = json::array(), y = json::array(), model_x = json::array(), model_y = json::array();
    for (const auto& [place, point] : line) {
      x.push_back(measured_at(point, along));
      y.push_back(measured_at(point, 2));
      model_x.push_back(value(last, 3 * point + along));
      model_y.push_back(value(last, 3 * point + 2));
    }
    return figure("profile", "Profile", {"along the strip", "m"}, {"height", "m"}, x, y, model_x,
                  model_y);
  }

  /// The sheet in the last frame with a rest.
  json mesh() const {
    const std::size_t last = found_.resting.size() - 1;
    const mechanics::State& state = found_.states[last];
    const int nodes = sequence_.cloth.mesh.node_count();
    std::vector<double> missed(static_cast<std::size_t>(nodes), -1.0);
    json arrows = json::array(), positions = json::array(), residuals = json::array();
    const std::size_t step = std::max<std::size_t>(1, sequence_.points.size() / 150);
    double square = 0.0, sigma = 0.0;
    for (std::size_t p = 0; p < sequence_.points.size(); ++p) {
      const auto place =
          estimation::locate(sequence_.cloth.mesh, sequence_.points[p].material_m).value();
      const Eigen::Vector3d at = place.position(state.x);
      const Eigen::Vector3d left =
          frame(found_.resting[last]).points_m.col(static_cast<Eigen::Index>(p)) - at;
      if (!left.allFinite()) continue;
      square += left.squaredNorm();
      sigma = sequence_.points[p].sigma_m;
      for (std::size_t a = 0; a < 3; ++a)
        if (place.weight[a] > 0.5) missed[static_cast<std::size_t>(place.nodes[a])] = left.norm();
      if (p % step == 0) arrows.push_back({{"at_m", numbers(at)}, {"residual_m", numbers(left)}});
    }
    for (Eigen::Index n = 0; n < nodes; ++n) {
      positions.push_back(numbers(state.x.segment<3>(3 * n)));
      const double of = missed[static_cast<std::size_t>(n)];
      residuals.push_back(of < 0.0 ? json(nullptr) : json(of));
    }
    const auto points = static_cast<double>(std::max<std::size_t>(1, sequence_.points.size()));
    return {{"capture", id_},
            {"title", id_},
            {"frame", found_.resting[last] + 1},
            {"why", "last frame"},
            {"triangles", sequence_.cloth.mesh.triangles},
            {"position_m", positions},
            {"residual_m", residuals},
            {"sigma_m", sigma > 0.0 ? json(sigma) : json(nullptr)},
            {"arrows", arrows},
            {"rms_m", std::sqrt(square / points)}};
  }

 private:
  using Axis = std::pair<const char*, const char*>;

  static json numbers(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

  const estimation::SequenceFrame& frame(int f) const {
    return sequence_.frames[static_cast<std::size_t>(f)];
  }

  double value(std::size_t resting, int channel) const {
    const estimation::SequenceFrame& at = frame(found_.resting[resting]);
    estimation::Observation seen;
    channels_.observe(sequence_, channel,
                      {sequence_.boundaries[static_cast<std::size_t>(at.boundary)],
                       found_.states[resting], found_.by_node_N[resting]},
                      seen);
    return seen.value;
  }

  double way_m(int f) const {
    double farthest = 0.0;
    const auto& first = sequence_.frames.front().clips;
    for (std::size_t c = 0; c < first.size(); ++c)
      farthest = std::max(farthest, (frame(f).clips[c].position_m - first[c].position_m).norm());
    return farthest;
  }

  json figure(const char* kind, const char* title, Axis x, Axis y, const json& measured_x,
              const json& measured_y, const json& model_x, const json& model_y) const {
    return {{"kind", kind},
            {"capture", id_},
            {"title", title},
            {"x", {{"name", x.first}, {"unit", x.second}}},
            {"y", {{"name", y.first}, {"unit", y.second}}},
            {"series",
             {{{"name", "measured"}, {"role", "measured"}, {"x", measured_x}, {"y", measured_y}},
              {{"name", "model"}, {"role", "extended"}, {"x", model_x}, {"y", model_y}}}}};
  }

  std::string id_;
  Role role_;
  const Sequence& sequence_;
  estimation::Observations channels_;
  estimation::RestingFrames found_;
};

/// Of the first specimen, which stands before the second.
json error_of(const estimation::AppendixRow& row, const std::string& sequence, bool of_forces) {
  for (const auto* list : {&row.training, &row.others})
    for (const estimation::ScenarioResidual& r : *list)
      if (r.sequence == sequence && (of_forces ? r.force_rows : r.points) > 0)
        return {{"rms_after", of_forces ? r.force_N : 1e-3 * r.position_mm}};
  return nullptr;
}

}  // namespace

Expected<void> AppendixPage::add(const std::string& fabric, const estimation::AppendixRow& row,
                                 const std::vector<estimation::RoleSequence>& sequences) {
  const Eigen::VectorXd parameters = mechanics::term_parameters(row.fit.model);
  for (const estimation::RoleSequence& s : sequences) {
    auto found = estimation::resting_frames(row.fit.model, s.sequence, parameters, 1e-6);
    if (!found) return tl::unexpected(found.error());
    if (found->resting.empty()) continue;
    const std::string id = "#" + fabric + " " + s.sequence.name + ", " +
                           words_of(row.variant.cloth) + " " + words_of(row.variant);
    captures_.push_back({{"id", id},
                         {"title", id},
                         {"synthetic", true},
                         {"held_out", s.role == Role::evaluation},
                         {"frames", found->resting.size()},
                         {"position", error_of(row, s.sequence.name, false)},
                         {"force", error_of(row, s.sequence.name, true)}});
    const Shown shown(id, s.role, s.sequence, std::move(*found));
    const bool is_bent = s.role == Role::bend_u || s.role == Role::bend_v;
    if (json figure = is_bent ? shown.profile() : shown.loop(); !figure.is_null())
      figures_.push_back(std::move(figure));
    if (!s.sequence.points.empty()) meshes_.push_back(shown.mesh());
  }
  return {};
}

Expected<std::string> AppendixPage::html() const {
  return report::render_html(json{
      {"schema", "tenter.sheet_fit"},
      {"version", 1},
      {"kind", "fit"},
      {"captures", captures_},
      {"figures", figures_},
      {"meshes", meshes_}}.dump());
}

}  // namespace tenter::bench
