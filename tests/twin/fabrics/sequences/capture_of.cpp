// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/capture_of.h"

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "common/base/not_a_number.h"

namespace tenter::twin {

namespace {

using capture::Capture;
using capture::Sheet;
using estimation::Sequence;

capture::Vec3 list_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

capture::RigidPose pose_of(const ClipPose& pose) {
  const Eigen::Quaterniond q(pose.rotation);
  return {list_of(pose.position_m), {q.w(), q.x(), q.y(), q.z()}};
}

/// For each point of the sequence its node, where all of them are nodes.
std::vector<int> nodes_of_points(const Sequence& sequence) {
  std::map<std::pair<double, double>, int> node_at;
  const auto& mesh = sequence.cloth.mesh;
  for (int n = 0; n < mesh.node_count(); ++n)
    node_at[{mesh.material_m(0, n), mesh.material_m(1, n)}] = n;
  std::vector<int> nodes;
  for (const estimation::PointChannel& point : sequence.points) {
    const auto found = node_at.find({point.material_m.x(), point.material_m.y()});
    if (found == node_at.end()) return {};
    nodes.push_back(found->second);
  }
  return nodes;
}

void add_mesh(const Sequence& sequence, Sheet& sheet) {
  std::vector<int> vertex = nodes_of_points(sequence);
  const auto& mesh = sequence.cloth.mesh;
  if (!vertex.empty()) {
    for (int n = 0; n < mesh.node_count(); ++n)
      sheet.material_m.push_back({mesh.material_m(0, n), mesh.material_m(1, n)});
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (mesh.layer(t) == 0)
        sheet.triangles.push_back(mesh.triangles[static_cast<std::size_t>(t)]);
  } else {
    for (const estimation::PointChannel& point : sequence.points) {
      vertex.push_back(static_cast<int>(sheet.material_m.size()));
      sheet.material_m.push_back({point.material_m.x(), point.material_m.y()});
    }
  }
  sheet.may_be_missing = true;
  sheet.sigma_m = sequence.points.front().sigma_m;
  sheet.position_m.assign(3 * sequence.frames.size() * sheet.vertex_count(), kNaN);
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    for (std::size_t k = 0; k < vertex.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        sheet.position_m[sheet.at(f, static_cast<std::size_t>(vertex[k])) + c] =
            sequence.frames[f].points_m(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(k));
}

void add_clips(const Protocol& protocol, Sheet& sheet) {
  for (std::size_t c = 0; c < protocol.clips.size(); ++c) {
    const ProtocolClip& from = protocol.clips[c];
    const Region& grip = from.grip;
    capture::ClipTrack clip;
    clip.id = from.id;
    clip.region_m = {{grip.lo_u, grip.lo_v},
                     {grip.hi_u, grip.lo_v},
                     {grip.hi_u, grip.hi_v},
                     {grip.lo_u, grip.hi_v}};
    clip.mass_kg = from.mass_kg;
    clip.centre_of_mass_m = {0.5 * (grip.lo_u + grip.hi_u), 0.5 * (grip.lo_v + grip.hi_v), 0.0};
    for (const ProtocolFrame& frame : protocol.frames) clip.pose.push_back(pose_of(frame.poses[c]));
    sheet.clips.push_back(std::move(clip));
  }
}

void add_cords(const Sequence& sequence, Sheet& sheet) {
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const estimation::ForceChannel& force = sequence.forces[k];
    const auto clip = static_cast<std::size_t>(force.clip);
    capture::CordTrack cord;
    cord.id = "cord_" + std::to_string(k + 1);
    cord.clip = sheet.clips[clip].id;
    cord.attachment_m = sheet.clips[clip].centre_of_mass_m;
    cord.sigma_N = force.sigma_N;
    for (const estimation::SequenceFrame& frame : sequence.frames) {
      const Eigen::Matrix3d turn =
          force.turns_with_clip ? frame.clips[clip].rotation : Eigen::Matrix3d::Identity();
      cord.direction.push_back(list_of(turn * force.direction));
      cord.tension_N.push_back(frame.forces_N[static_cast<Eigen::Index>(k)]);
    }
    sheet.cords.push_back(std::move(cord));
  }
}

/// The table bears the strip from its end to an edge along u or v.
void add_table(const Protocol& protocol, Sheet& sheet) {
  if (!protocol.frames.front().table) return;
  capture::SupportTrack table;
  table.id = "table";
  table.bears_above = false;
  const Region& first = *protocol.frames.front().table;
  table.along = first.hi_u < first.hi_v ? 'u' : 'v';
  for (const ProtocolFrame& frame : protocol.frames)
    table.edge_m.push_back(table.along == 'u' ? frame.table->hi_u : frame.table->hi_v);
  table.pose.resize(protocol.frames.size());
  sheet.supports.push_back(std::move(table));
}

}  // namespace

Capture capture_of(const Fabric& fabric, const Protocol& protocol, const Sequence& sequence) {
  Capture capture;
  capture.kind = "deforming_sheet";
  capture.title = protocol.name;
  capture.specimen.name = fabric.id;
  capture.specimen.material = fabric.name;
  capture.specimen.length_m = capture.specimen.width_m = fabric.side_m;
  capture.specimen.mass_kg = fabric.mass_kg;
  capture.protocol.name = protocol.name;
  capture.protocol.phases = {{protocol.name, "cycle", std::nullopt}};
  capture.provenance.synthetic = true;
  capture.provenance.source = "twin fabric " + fabric.id;
  capture.runs = {{1, ""}};
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    capture.frame.push_back(static_cast<int>(f) + 1);
    capture.branch.push_back(sequence.frames[f].block % 2 == 0 ? capture::Branch::load
                                                               : capture::Branch::unload);
  }
  capture.run.assign(capture.frame.size(), 0);
  capture.phase.assign(capture.frame.size(), 0);
  Sheet& sheet = capture.sheet.emplace();
  add_mesh(sequence, sheet);
  const double side = fabric.side_m;
  if (sheet.triangles.empty())
    sheet.outline_m = {{0.0, 0.0}, {side, 0.0}, {side, side}, {0.0, side}};
  add_clips(protocol, sheet);
  add_cords(sequence, sheet);
  add_table(protocol, sheet);
  sheet.gravity_m_s2 = list_of(sequence.loads.gravity_m_s2);
  return capture;
}

}  // namespace tenter::twin
