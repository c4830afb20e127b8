// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include "common/model/presets.h"
#include "server/estimation/prediction.h"
#include "server/estimation/sequences/from_capture.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::testing {
namespace {

using capture::Capture;
using capture::Sheet;
using capture::Vec3;

constexpr double kSize_m = 0.1;

/// A square at rest in every frame, held by nothing.
Capture square(const SheetCaptureOptions& options) {
  Capture made;
  made.kind = "deforming_sheet";
  made.title = options.role + " of a made cloth";
  made.specimen.name = "square";
  made.specimen.material = "made cloth";
  made.specimen.area_density_kg_m2 = 0.15;
  made.provenance.synthetic = true;
  made.protocol.phases = {{"test", "other", std::nullopt}};
  made.runs = {{1, ""}};
  const auto frames = static_cast<std::size_t>(options.frames);
  for (std::size_t f = 0; f < frames; ++f) {
    made.frame.push_back(static_cast<int>(f) + 1);
    made.branch.push_back(capture::Branch::load);
  }
  made.run.assign(frames, 0);
  made.phase.assign(frames, 0);
  Sheet& sheet = made.sheet.emplace();
  const auto mesh = mechanics::grid_mesh({options.nodes, options.nodes, kSize_m, kSize_m},
                                         mechanics::Diagonals::one)
                        .value();
  for (int n = 0; n < mesh.node_count(); ++n)
    sheet.material_m.push_back({mesh.material_m(0, n), mesh.material_m(1, n)});
  sheet.triangles = mesh.triangles;
  for (std::size_t f = 0; f < frames; ++f)
    for (const auto& [u, v] : sheet.material_m)
      sheet.position_m.insert(sheet.position_m.end(), {u, v, 0.0});
  sheet.sigma_m = options.sigma_m;
  return made;
}

/// Two bars across the pull, the second one moved, with a cord along its way.
void pull(Capture& made, const SheetCaptureOptions& options, const Vec3& moved, bool along_u) {
  Sheet& sheet = *made.sheet;
  sheet.gravity_m_s2 = {0.0, 0.0, 0.0};
  const auto bar = [&](const std::string& id, double at_m) {
    capture::ClipTrack clip;
    clip.id = id;
    const double lo = at_m - 1e-4;
    const double hi = at_m + 1e-4;
    const double end = kSize_m + 1e-4;
    clip.region_m =
        along_u ? std::vector<capture::Vec2>{{lo, -1e-4}, {hi, -1e-4}, {hi, end}, {lo, end}}
                : std::vector<capture::Vec2>{{-1e-4, lo}, {end, lo}, {end, hi}, {-1e-4, hi}};
    clip.pose.resize(made.frame_count());
    return clip;
  };
  sheet.clips = {bar("still", 0.0), bar("moved", kSize_m)};
  const double length = std::hypot(moved[0], moved[1]);
  capture::CordTrack cord;
  cord.id = "cord";
  cord.clip = "moved";
  cord.sigma_N = options.sigma_N;
  for (std::size_t f = 0; f < made.frame_count(); ++f) {
    const double share = static_cast<double>(f + 1) / static_cast<double>(made.frame_count());
    sheet.clips[1].pose[f].position_m = {moved[0] * share, moved[1] * share, 0.0};
    cord.tension_N.push_back(1.0);
    cord.direction.push_back({moved[0] / length, moved[1] / length, 0.0});
  }
  sheet.cords = {cord};
}

/// The bar is free instead, and two cords with tensions of their own pull it.
void hang(Capture& made, const SheetCaptureOptions& options) {
  Sheet& sheet = *made.sheet;
  sheet.clips[1].is_free = true;
  sheet.cords.push_back(sheet.cords[0]);
  sheet.cords[1].id = "other_cord";
  for (std::size_t c = 0; c < 2; ++c) {
    sheet.cords[c].attachment_m = {c == 0 ? 0.2 * kSize_m : 0.85 * kSize_m, 1.1 * kSize_m, 0.0};
    for (std::size_t f = 0; f < made.frame_count(); ++f) {
      const double share = static_cast<double>(f + 1) / static_cast<double>(made.frame_count());
      sheet.cords[c].tension_N[f] = 0.5 * share * options.pull_N;
    }
  }
}

void push_over_edge(Capture& made, bool along_u) {
  capture::SupportTrack table;
  table.id = "table";
  table.along = along_u ? 'u' : 'v';
  table.bears_above = false;
  table.pose.resize(made.frame_count());
  for (std::size_t f = 0; f < made.frame_count(); ++f)
    table.edge_m.push_back(0.06 -
                           0.03 * static_cast<double>(f) / static_cast<double>(made.frame_count()));
  made.sheet->supports = {table};
}

estimation::CapturedSequence sequence_of(const Capture& made, const SheetCaptureOptions& options) {
  estimation::FromCaptureOptions how;
  how.nodes_u = how.nodes_v = options.nodes;
  how.start_from_measured = false;
  auto captured = estimation::sequence_from_capture(made, how);
  if (!captured) throw std::runtime_error(captured.error().message);
  return std::move(*captured);
}

/// Puts equilibria and the tensions that hold them into the capture, with noise.
void simulate(Capture& made, const SheetCaptureOptions& options) {
  Sheet& sheet = *made.sheet;
  const estimation::CapturedSequence captured = sequence_of(made, options);
  const estimation::Sequence& sequence = captured.sequence;
  const model::Model& cloth = options.cloth;
  const auto mesh_model = mechanics::MeshModel::make(cloth, sequence.cloth).value();
  const Eigen::VectorXd parameters = estimation::parameter_values(cloth);
  std::mt19937 random(options.seed);
  std::normal_distribution<double> normal;
  mechanics::State state = sequence.start;
  mechanics::EquilibriumOptions how;
  how.tolerance_N = 1e-9;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const auto b = static_cast<std::size_t>(sequence.frames[f].boundary);
    auto solver = mechanics::EquilibriumSolver::make(mesh_model, sequence.boundaries[b]).value();
    prescribe(sequence, f, true, state);
    mechanics::Loads loads = sequence.loads;
    loads.cord_force_N = sequence.frames[f].cord_force_N;
    const auto solved = solver.solve(parameters, loads, state, how);
    if (!solved || !solved->is_good(how)) throw std::runtime_error("no equilibrium");
    for (std::size_t k = 0; k < sheet.vertex_count(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        sheet.position_m[sheet.at(f, k) + c] =
            state.x[static_cast<Eigen::Index>(3 * k + c)] + options.sigma_m * normal(random);
    for (std::size_t c = 0; c < sheet.clips.size(); ++c)
      if (sheet.clips[c].is_free) {
        const Eigen::Vector3d& at = state.clips[c].position_m;
        sheet.clips[c].pose[f].position_m = {at.x(), at.y(), at.z()};
      }
    for (capture::CordTrack& cord : sheet.cords) {
      if (sheet.find_clip(cord.clip)->is_free) continue;  // a load, not an answer
      const mechanics::Clip& clip = sequence.boundaries[b].clips[1];
      const Eigen::Vector3d pulled =
          mechanics::reaction(clip, state.x, solved->by_node, Eigen::Vector3d::Zero()).force_N;
      const Vec3& d = cord.direction[f];
      cord.tension_N[f] =
          -pulled.dot(Eigen::Vector3d(d[0], d[1], d[2])) + options.sigma_N * normal(random);
    }
  }
}

}  // namespace

model::Model true_cloth() {
  model::Model cloth = model::preset("cloth_stvk").value();
  const double values[] = {45.0, 80.0, 9.0, 4e-5, 6e-5, 5e-5};
  const auto parameters = estimation::parameters_of(cloth);
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i]->value = values[i];
  return cloth;
}

Capture sheet_capture(const SheetCaptureOptions& options) {
  Capture made = square(options);
  if (options.role == "bend_u" || options.role == "bend_v") {
    push_over_edge(made, options.role == "bend_u");
  } else {
    const double by = 4e-3 * options.reach;
    const bool along_u = options.role != "stretch_v" && options.role != "hung_v";
    const Vec3 moved = options.role == "shear" ? Vec3{0.5 * by, by, 0.0}
                       : along_u               ? Vec3{by, 0.0, 0.0}
                                               : Vec3{0.0, by, 0.0};
    pull(made, options, moved, along_u);
    if (options.role == "hung_v") hang(made, options);
  }
  simulate(made, options);
  return made;
}

}  // namespace tenter::testing
