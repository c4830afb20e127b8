// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <utility>

#include "common/frames/frames_file.h"
#include "common/h5/writer.h"

namespace tenter::frames {

namespace {

using h5::H5Writer;
using Axes = std::vector<std::string>;

std::size_t size_of(int count) {
  return static_cast<std::size_t>(count);
}

/// An NXdata group whose signal a viewer draws.
void data_group(H5Writer& file, const std::string& path, const std::string& signal,
                const Axes& axes) {
  file.group(path, "NXdata");
  file.attribute(path, "signal", signal);
  file.attribute(path, "axes", axes);
}

std::vector<int> numbers(int count) {
  std::vector<int> list(size_of(count));
  for (int i = 0; i < count; ++i) list[size_of(i)] = i;
  return list;
}

/// "/entry/frames/000012/"
std::string folder_of(int frame) {
  char text[32];
  std::snprintf(text, sizeof text, "/entry/frames/%06d/", frame);
  return text;
}

/// A list over frames: one dataset a frame, which is what readers of XDMF take, and all of them
/// as one under `path`.
void over_frames(H5Writer& file, const std::string& path, const std::string& part,
                 const std::vector<double>& values, int frames,
                 const std::vector<std::size_t>& shape, const std::string& unit) {
  const auto size = static_cast<std::ptrdiff_t>(values.size() / size_of(frames));
  std::vector<std::string> parts;
  for (int frame = 0; frame < frames; ++frame) {
    const auto begin = values.begin() + frame * size;
    parts.push_back(folder_of(frame) + part);
    file.array(parts.back(), std::vector<double>(begin, begin + size), shape, unit);
  }
  file.stack(path, parts, shape, unit);
}

void write_solution(H5Writer& file, const FrameSet& f) {
  const std::string group = "/entry/solution";
  data_group(file, group, "net_force", {"frame"});
  file.array(group + "/frame", numbers(f.frame_count()));
  file.array(group + "/phase", f.phase);
  if (!f.phases.empty()) file.attribute(group + "/phase", "labels", f.phases);
  file.array(group + "/phase_share", f.phase_share, "1");
  file.array(group + "/steps", f.steps);
  file.array(group + "/iterations", f.iterations);
  file.array(group + "/factorisations", f.factorisations);
  file.array(group + "/stability", f.stability);
  file.attribute(group + "/stability", "labels",
                 std::vector<std::string>{"minimum", "neutral", "not_checked"});
  file.array(group + "/net_force", f.net_force_N, "N");
  file.array(group + "/contact_violation", f.contact_violation_m, "m");
  file.array(group + "/limit_violation", f.limit_violation, "1");
  file.array(group + "/gravity_factor", f.gravity_factor, "1");
  file.array(group + "/pressure", f.pressure_Pa, "Pa");
  if (f.time_s.empty()) return;
  file.array(group + "/time", f.time_s, "s");
  file.array(group + "/step_error", f.step_error_m, "m");
  file.attribute(group + "/step_error", "long_name",
                 std::string("estimated errors of the time steps since the frame before"));
}

void write_mesh(H5Writer& file, const FrameSet& f) {
  file.group("/entry/mesh", "NXcollection");
  file.array("/entry/mesh/material", f.material_m, {size_of(f.nodes), size_of(f.coordinates)}, "m");
  for (const Elements& e : f.elements)
    if (e.count() > 0)
      file.array("/entry/mesh/" + e.kind, e.nodes, {size_of(e.count()), size_of(e.corners)});
  const std::string group = "/entry/positions";
  data_group(file, group, "position", {"frame", "node", "component"});
  over_frames(file, group + "/position", "position", f.position_m, f.frame_count(),
              {size_of(f.nodes), 3}, "m");
  file.array(group + "/frame", numbers(f.frame_count()));
  if (!f.velocity_m_s.empty())
    over_frames(file, group + "/velocity", "velocity", f.velocity_m_s, f.frame_count(),
                {size_of(f.nodes), 3}, "m/s");
}

void write_clips(H5Writer& file, const FrameSet& f) {
  if (f.clips.empty()) return;
  const std::size_t frames = size_of(f.frame_count());
  const std::string group = "/entry/reactions";
  data_group(file, group, "force", {"frame", "clip", "component"});
  file.array(group + "/frame", numbers(f.frame_count()));
  file.array(group + "/clip", f.clips);
  file.array(group + "/component", Axes{"x", "y", "z"});
  file.array(group + "/force", f.force_N, {frames, f.clips.size(), 3}, "N");
  file.attribute(group + "/force", "long_name",
                 std::string("force of the material on the clip, with the weight of its nodes"));
  file.array(group + "/torque", f.torque_N_m, {frames, f.clips.size(), 3}, "N m");
  file.attribute(group + "/torque", "long_name",
                 std::string("the same as a torque about the clip's position"));
  file.array(group + "/position", f.clip_position_m, {frames, f.clips.size(), 3}, "m");
  file.array(group + "/rotation", f.clip_rotation, {frames, f.clips.size(), 3, 3}, "1");
  if (f.cords.empty()) return;
  file.group("/entry/cords", "NXdata");
  file.attribute("/entry/cords", "signal", std::string("force"));
  file.attribute("/entry/cords", "axes", Axes{"frame", "cord", "component"});
  file.array("/entry/cords/cord", f.cords);
  file.array("/entry/cords/force", f.cord_force_N, {frames, f.cords.size(), 3}, "N");
}

void write_energies(H5Writer& file, const FrameSet& f) {
  const std::string group = "/entry/energies";
  data_group(file, group, "energy", {"frame", "term"});
  file.array(group + "/frame", numbers(f.frame_count()));
  file.array(group + "/term", f.terms);
  file.array(group + "/energy", f.term_energy_J, {size_of(f.frame_count()), f.terms.size()}, "J");
  file.array(group + "/potential", f.potential_J, "J");
  file.attribute(group + "/potential", "long_name",
                 std::string("material, loads and contact: what equilibrium minimises"));
  if (!f.kinetic_J.empty()) file.array(group + "/kinetic", f.kinetic_J, "J");
}

void write_strains(H5Writer& file, const FrameSet& f) {
  file.group("/entry/strains", "NXcollection");
  int number = 0;
  for (const StrainSeries& s : f.strains) {
    char prefix[16];
    std::snprintf(prefix, sizeof prefix, "%02d_", ++number);
    const std::string name = (prefix + s.term) + "_" + s.kind;
    const std::string group = "/entry/strains/" + name;
    const bool solid = s.kind == "tetrahedron" || s.kind == "hexahedron";
    data_group(file, group, s.strains() == 1 ? "strain" : "strain_1", {"frame", "element"});
    file.attribute(group, "term", s.term);
    file.attribute(group, "measure", s.measure);
    file.attribute(group, "element_kind", s.kind);
    file.array(group + "/share", s.share, solid ? "m^3" : "m^2");
    for (int i = 0; i < s.strains(); ++i) {
      const std::string end = s.strains() == 1 ? "" : "_" + std::to_string(i + 1);
      const std::string path = group + "/strain" + end;
      const std::vector<double>& values = s.values[size_of(i)];
      if (solid || s.kind == "triangle")
        over_frames(file, path, name + end, values, f.frame_count(), {s.share.size()}, s.unit);
      else
        file.array(path, values, {size_of(f.frame_count()), s.share.size()}, s.unit);
    }
  }
}

}  // namespace

Expected<void> write_frames(const FrameSet& f, const std::string& path) {
  if (f.frame_count() == 0 || f.nodes == 0)
    return fail(ErrorKind::internal, path + ": there is no frame to write");
  if (f.frame_count() > kMostFrames)
    return bad_input(path + ": has more than " + std::to_string(kMostFrames) + " frames");
  H5Writer file(path);
  file.group("/", "NXroot");
  file.attribute("/", "default", std::string("entry"));
  file.attribute("/", "schema", std::string(kSchema));
  file.attribute("/", "version", std::int64_t{kVersion});
  file.group("/entry", "NXentry");
  file.attribute("/entry", "default", std::string(f.clips.empty() ? "energies" : "reactions"));
  file.text("/entry/title", f.title);
  file.text("/entry/scene", f.scene_json);
  file.text("/entry/model", f.model_json);
  file.group("/entry/frames", "NXcollection");
  for (int frame = 0; frame < f.frame_count(); ++frame) {
    std::string folder = folder_of(frame);
    folder.pop_back();
    file.group(folder, "NXcollection");
  }
  write_solution(file, f);
  write_mesh(file, f);
  write_clips(file, f);
  write_energies(file, f);
  write_strains(file, f);
  return std::move(file).save();
}

}  // namespace tenter::frames
