// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/from_capture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/base/not_a_number.h"
#include "server/estimation/sequences/material/captured_material.h"
#include "server/estimation/sequences/material/material_locator.h"
#include "server/estimation/sequences/material/measured_state.h"
#include "server/estimation/sequences/sensors/cord_directions.h"
#include "server/estimation/sequences/sensors/hidden_points.h"

namespace tenter::estimation {

namespace {

using capture::Capture;
using capture::CordTrack;
using capture::Sheet;

/// The making of one sequence, step by step; each step fills one part of it.
class Making {
 public:
  Making(const Capture& capture, const FromCaptureOptions& options)
      : capture_(capture), sheet_(*capture.sheet), options_(options) {}

  Expected<CapturedSequence> run() {
    sequence().name = capture_.title;
    if (auto ok = choose_frames(); !ok) return tl::unexpected(ok.error());
    auto cloth = cloth_of(sheet_, options_, out_.frame, out_.use.has_graded_grid);
    if (!cloth) return tl::unexpected(cloth.error());
    sequence().cloth = std::move(*cloth);
    if (auto ok = make_loads(); !ok) return tl::unexpected(ok.error());
    if (auto ok = make_clips(); !ok) return tl::unexpected(ok.error());
    if (auto ok = make_points(); !ok) return tl::unexpected(ok.error());
    if (auto ok = make_forces(); !ok) return tl::unexpected(ok.error());
    make_frames();
    make_starts();
    if (auto ok = check(sequence()); !ok) return tl::unexpected(ok.error());
    return std::move(out_);
  }

 private:
  Sequence& sequence() { return out_.sequence; }
  const mechanics::SurfaceMesh& mesh() const { return out_.sequence.cloth.mesh; }

  /// Those asked for, without frames that are slack or in which the load of a free clip is not
  /// known, thinned.
  Expected<void> choose_frames() {
    std::vector<std::size_t> asked = options_.frames;
    if (asked.empty()) {
      asked.resize(capture_.frame_count());
      std::iota(asked.begin(), asked.end(), std::size_t{0});
    }
    for (std::size_t i = 0; i < asked.size(); ++i)
      if (asked[i] >= capture_.frame_count() || (i > 0 && asked[i] <= asked[i - 1]))
        return bad_input("the frames asked for do not rise, or are not in the capture");
    for (const std::size_t f : asked) {
      const bool is_usable =
          std::none_of(sheet_.cords.begin(), sheet_.cords.end(), [&](const CordTrack& cord) {
            return std::isnan(cord.tension_N[f]) && sheet_.find_clip(cord.clip)->is_free;
          });
      (sheet_.is_slack(f) ? out_.use.slack_frames
       : is_usable        ? out_.frame
                          : out_.use.dropped_frames)
          .push_back(f);
    }
    thin_frames();
    out_.use.frames = static_cast<int>(out_.frame.size());
    if (out_.frame.empty())
      return bad_input(out_.use.slack_frames.empty() ? "no frame is left"
                                                     : "no frame is left that is not slack");
    return {};
  }

  /// The first and the last stay.
  void thin_frames() {
    const std::size_t all = out_.frame.size();
    const auto most = static_cast<std::size_t>(std::max(options_.most_frames, 0));
    if (most == 0 || all <= most) return;
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < most; ++i)
      kept.push_back(out_.frame[most == 1 ? all - 1 : i * (all - 1) / (most - 1)]);
    out_.frame = std::move(kept);
    out_.use.thinned_frames = static_cast<int>(all - most);
  }

  Expected<void> make_loads() {
    mechanics::Loads& loads = sequence().loads;
    loads.gravity_m_s2 = vector_of(sheet_.gravity_m_s2);
    if (loads.gravity_m_s2.isZero(0.0)) return {};
    const capture::Specimen& specimen = capture_.specimen;
    if (!specimen.mass_kg && !specimen.area_density_kg_m2)
      return bad_input("there is gravity, but the specimen has neither a mass nor an area density");
    const std::vector<double> masses =
        specimen.mass_kg ? mechanics::lumped_masses_of_total_kg(mesh(), *specimen.mass_kg)
                         : mechanics::lumped_masses_kg(mesh(), *specimen.area_density_kg_m2);
    loads.node_mass_kg =
        Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
    return {};
  }

  Expected<void> make_clips() {
    auto nodes = clamped_nodes(sheet_, mesh(), options_.use_own_mesh);
    if (!nodes) return tl::unexpected(nodes.error());
    is_clamped_.assign(static_cast<std::size_t>(mesh().node_count()), false);
    for (std::size_t c = 0; c < sheet_.clips.size(); ++c) {
      const capture::ClipTrack& from = sheet_.clips[c];
      mechanics::Clip clip;
      clip.id = from.id;
      clip.nodes = (*nodes)[c];
      const mechanics::Pose grip = pose_of(from.grip);
      for (const int node : clip.nodes) {
        const Eigen::Vector2d place = mesh().material_m.col(node);
        clip.place_m.push_back(grip.to_space({place.x(), place.y(), 0.0}));
        is_clamped_[static_cast<std::size_t>(node)] = true;
      }
      clip.is_free = from.is_free;
      clip.mass_kg = from.mass_kg;
      clip.centre_of_mass_m = vector_of(from.centre_of_mass_m);
      for (const CordTrack& cord : sheet_.cords)
        if (cord.clip == from.id) clip.cord_place_m.push_back(vector_of(cord.attachment_m));
      out_.use.clip_nodes.push_back(static_cast<int>(clip.nodes.size()));
      clips_.push_back(std::move(clip));
    }
    return {};
  }

  // ---- what is compared

  bool is_seen(int vertex) const {
    for (const std::size_t f : out_.frame)
      for (int c = 0; c < sheet_.coordinates; ++c)
        if (!std::isnan(coordinate(f, vertex, c))) return true;
    return false;
  }

  double coordinate(std::size_t frame, int vertex, int c) const {
    return c < sheet_.coordinates
               ? sheet_.position_m[sheet_.at(frame, static_cast<std::size_t>(vertex)) +
                                   static_cast<std::size_t>(c)]
               : kNaN;
  }

  Expected<void> make_points() {
    const MaterialLocator locator(mesh());
    const std::vector<bool> in_clips = vertices_in_clips(sheet_, mesh());
    std::vector<int> candidates;
    CaptureUse& use = out_.use;
    use.vertices = static_cast<int>(sheet_.vertex_count());
    std::map<int, MaterialLocation> location_of;
    std::vector<Eigen::Vector2d> tracked;
    for (int vertex = 0; vertex < use.vertices; ++vertex) {
      const auto k = static_cast<std::size_t>(vertex);
      const auto at = locator.locate({sheet_.material_m[k][0], sheet_.material_m[k][1]});
      if (in_clips[k] || !at) {
        ++(in_clips[k] ? use.in_clips : use.outside);
        continue;
      }
      tracked.emplace_back(sheet_.material_m[k][0], sheet_.material_m[k][1]);
      location_of.emplace(vertex, *at);
      if (is_seen(vertex))
        candidates.push_back(vertex);
      else
        ++use.never_seen;
    }
    sequence().spacing_m = spacing_m(tracked);
    out_.vertex = spread_evenly(sheet_.material_m, candidates, options_.most_points);
    use.points = static_cast<int>(out_.vertex.size());
    use.thinned = static_cast<int>(candidates.size()) - use.points;
    for (const int vertex : out_.vertex) {
      const auto k = static_cast<std::size_t>(vertex);
      double sigma =
          sheet_.sigma_per_vertex_m.empty() ? sheet_.sigma_m : sheet_.sigma_per_vertex_m[k];
      if (sigma == 0.0) sigma = options_.unknown_sigma_m;
      if (!(sigma > 0.0))
        return bad_input(
            "the capture does not say how noisy its positions are (positions.sigma, in metres; the "
            "option sigma_m stands in for it)");
      sequence().points.push_back({{sheet_.material_m[k][0], sheet_.material_m[k][1]}, sigma});
      locations_.push_back(location_of.at(vertex));
      location_of.erase(vertex);
    }
    others_.assign(location_of.begin(), location_of.end());
    return {};
  }

  /// Sum of the cords of a clip in a frame; NaN where one was not measured.
  Eigen::Vector3d pull_of(const std::string& clip, std::size_t frame) const {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (const CordTrack& cord : sheet_.cords)
      if (cord.clip == clip) pull += cord.tension_N[frame] * vector_of(cord.direction[frame]);
    return pull;
  }

  /// In space, in a frame of the capture.
  Eigen::Vector3d direction_of(const ForceChannel& force, std::size_t frame) const {
    if (!force.turns_with_clip) return force.direction;
    const auto clip = static_cast<std::size_t>(force.clip);
    return pose_of(sheet_.clips[clip].pose[frame]).rotation * force.direction;
  }

  /// The name, or one after it where that is taken.
  std::string free_name(const std::string& name) const {
    const auto is_taken = [&](const std::string& other) {
      const auto& forces = out_.sequence.forces;
      return std::any_of(forces.begin(), forces.end(),
                         [&](const ForceChannel& force) { return force.name == other; });
    };
    std::string free = name;
    for (int k = 2; is_taken(free); ++k) free = name + "_" + std::to_string(k);
    return free;
  }

  /// `name`: of the cord along it, or else of the clip.
  Expected<void> add_force(int clip, const std::string& name, const Eigen::Vector3d& direction,
                           bool turns_with_clip) {
    ForceChannel force;
    force.name = free_name(name);
    force.clip = clip;
    force.direction = direction.normalized();
    force.turns_with_clip = turns_with_clip;
    double variance = 0.0;
    double largest = 0.0;
    for (const CordTrack& cord : sheet_.cords) {
      if (cord.clip != clips_[static_cast<std::size_t>(clip)].id) continue;
      const double sigma = cord.sigma_N > 0.0 ? cord.sigma_N : options_.unknown_sigma_N;
      if (!(sigma > 0.0))
        return bad_input("cord \"" + cord.id +
                         "\" does not say how noisy its tension is (its tension.sigma, in newtons; "
                         "the option sigma_N stands in for it)");
      double share = 0.0;  // of its noise that shows along the direction, over the frames
      for (const std::size_t f : out_.frame)
        share += std::pow(direction_of(force, f).dot(vector_of(cord.direction[f])), 2);
      variance += sigma * sigma * share / static_cast<double>(out_.frame.size());
      largest = std::max(largest, sigma);
    }
    // across its cords a clip's force is known from their directions, which have a noise as well
    constexpr double kLeastShare = 0.1;
    force.sigma_N = std::max(std::sqrt(variance), kLeastShare * largest);
    sequence().forces.push_back(force);
    return {};
  }

  Expected<void> make_forces() {
    for (const FromCaptureOptions::Force& asked : options_.forces)
      if (!sheet_.find_clip(asked.clip) || !(asked.direction.norm() > 0.0))
        return bad_input("a force is asked for of clip \"" + asked.clip +
                         "\", which is not there, or along no direction");
    for (std::size_t c = 0; c < clips_.size(); ++c) {
      if (clips_[c].is_free || clips_[c].cord_place_m.empty()) continue;
      bool is_asked = false;
      for (const FromCaptureOptions::Force& asked : options_.forces) {
        if (asked.clip != clips_[c].id) continue;
        is_asked = true;
        if (auto ok = add_force(static_cast<int>(c), clips_[c].id, asked.direction,
                                asked.turns_with_clip);
            !ok)
          return ok;
      }
      if (is_asked) continue;
      const CordDirections known = cord_directions(sheet_, sheet_.clips[c], out_.frame);
      for (const auto& [cord, direction] : known.along)
        if (auto ok = add_force(static_cast<int>(c), cord, direction, known.turns_with_clip); !ok)
          return ok;
    }
    return {};
  }

  // ---- frames

  /// The boundary with these held nodes; a new one where no frame had them before.
  int boundary_of(const std::vector<int>& held) {
    const auto [at, is_new] =
        boundary_of_held_.emplace(held, static_cast<int>(sequence().boundaries.size()));
    if (is_new) sequence().boundaries.push_back({held, clips_, {}});
    return at->second;
  }

  void make_frames() {
    int block = -1;
    for (std::size_t i = 0; i < out_.frame.size(); ++i) {
      const std::size_t f = out_.frame[i];
      SequenceFrame frame;
      HeldNodes held = held_nodes(sheet_, f, mesh(), is_clamped_, options_.clamps_at_edge);
      frame.boundary = boundary_of(held.nodes);
      frame.held_m = std::move(held.place_m);
      for (std::size_t c = 0; c < clips_.size(); ++c) {
        frame.clips.push_back(pose_of(sheet_.clips[c].pose[f]));
        auto& cords = frame.cord_force_N.emplace_back();
        for (const CordTrack& cord : sheet_.cords)
          if (cord.clip == clips_[c].id)
            cords.push_back(clips_[c].is_free
                                ? Eigen::Vector3d(cord.tension_N[f] * vector_of(cord.direction[f]))
                                : Eigen::Vector3d::Zero());
      }
      read_points(f, held.nodes, frame);
      frame.forces_N.resize(static_cast<Eigen::Index>(sequence().forces.size()));
      for (std::size_t k = 0; k < sequence().forces.size(); ++k) {
        const ForceChannel& force = sequence().forces[k];
        const auto& id = clips_[static_cast<std::size_t>(force.clip)].id;
        const double value = direction_of(force, f).dot(pull_of(id, f));
        frame.forces_N[static_cast<Eigen::Index>(k)] = value;
        out_.use.missing_forces += std::isnan(value) ? 1 : 0;
      }
      const std::size_t before = i == 0 ? f : out_.frame[i - 1];
      if (i == 0 || capture_.run[f] != capture_.run[before] ||
          capture_.branch[f] != capture_.branch[before])
        ++block;
      frame.block = block;
      // a clock that starts again with a run says nothing of the time between both
      if (i > 0 && !capture_.time_s.empty())
        frame.duration_s = std::max(0.0, capture_.time_s[f] - capture_.time_s[before]);
      sequence().frames.push_back(std::move(frame));
    }
  }

  void read_points(std::size_t f, const std::vector<int>& held, SequenceFrame& frame) {
    std::vector<bool> is_fixed = is_clamped_;
    for (const int node : held) is_fixed[static_cast<std::size_t>(node)] = true;
    frame.points_m.resize(3, static_cast<Eigen::Index>(out_.vertex.size()));
    for (std::size_t k = 0; k < out_.vertex.size(); ++k) {
      const bool is_held = locations_[k].lies_on(is_fixed);
      for (int c = 0; c < 3; ++c) {
        double value = coordinate(f, out_.vertex[k], c);
        if (c < sheet_.coordinates) {
          const bool is_missing = std::isnan(value);
          ++(is_missing ? out_.use.missing : is_held ? out_.use.held : out_.use.readings);
        }
        if (is_held) value = kNaN;
        frame.points_m(c, static_cast<Eigen::Index>(k)) = value;
      }
    }
    for (const auto& [vertex, at] : others_) {
      const auto& [u, v] = sheet_.material_m[static_cast<std::size_t>(vertex)];
      if (std::isnan(coordinate(f, vertex, 0)) && !at.lies_on(is_fixed))
        frame.hidden_m.emplace_back(u, v);
    }
  }

  void make_starts() {
    const auto nodes = static_cast<std::size_t>(mesh().node_count());
    MeasuredStates fill(mesh(), locations_);
    for (std::size_t i = 0; i < out_.frame.size(); ++i) {
      SequenceFrame& frame = sequence().frames[i];
      const mechanics::Boundary& boundary =
          sequence().boundaries[static_cast<std::size_t>(frame.boundary)];
      mechanics::State state{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * nodes)),
                             frame.clips};
      mechanics::place_clips(boundary, state);
      std::vector<bool> is_fixed = is_clamped_;
      for (std::size_t k = 0; k < boundary.held.size(); ++k) {
        is_fixed[static_cast<std::size_t>(boundary.held[k])] = true;
        state.x.segment<3>(3 * static_cast<Eigen::Index>(boundary.held[k])) =
            frame.held_m.col(static_cast<Eigen::Index>(k));
      }
      fill.at(is_fixed, frame.points_m, state.x);
      if (i == 0) sequence().start = state;
      if (!options_.start_from_measured) return;
      frame.start = std::move(state);
    }
  }

  const Capture& capture_;
  const Sheet& sheet_;
  const FromCaptureOptions& options_;
  CapturedSequence out_;
  std::vector<mechanics::Clip> clips_;
  std::vector<bool> is_clamped_;
  std::vector<MaterialLocation> locations_;               ///< of the points
  std::vector<std::pair<int, MaterialLocation>> others_;  ///< vertices in the mesh that are none
  std::map<std::vector<int>, int> boundary_of_held_;
};

}  // namespace

Expected<CapturedSequence> sequence_from_capture(const Capture& capture,
                                                 const FromCaptureOptions& options) {
  if (!capture.sheet) return bad_input(capture.title + ": is not a capture of a deforming sheet");
  auto made = Making(capture, options).run();
  if (!made) return bad_input(capture.title + ": " + made.error().message);
  return made;
}

}  // namespace tenter::estimation
