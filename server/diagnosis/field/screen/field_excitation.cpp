// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/field_excitation.h"

#include <algorithm>
#include <cmath>

#include "common/model/catalogue.h"
#include "server/estimation/staged/splines/strain_histogram.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::diagnosis {
namespace {

using estimation::Curves;
using estimation::StrainHistogram;

constexpr double kDiagonal = 0.78539816339744831;
constexpr double kOutliers = 0.005;  // share of the area at each end of the strains, as stages have

/// Every measure that an effect may ask for, each as a term that does nothing.
model::Model probe() {
  model::Model model;
  const auto add = [&](const std::string& measure, double angle) {
    model::Term term = new_term(model, measure, measure, angle, "linear");
    set_parameter(term.law, "k", 0.0);
    model.terms.push_back(std::move(term));
  };
  for (const char* measure :
       {"green_u", "green_v", "green_uv", "soft_u", "soft_v", "soft_pair", "green_pair",
        "green_u_shear", "green_v_shear", "bend_u", "bend_v", "bend_d"})
    add(measure, 0.0);
  for (const char* measure : {"green_fibre_pair", "fibre_pair", "green_fibre"})
    add(measure, kDiagonal);
  return model;
}

/// Mean over the sheet of a one-strain measure.
double mean_of(const std::vector<mechanics::TermStrains>& strains, const model::Model& model,
               const char* measure) {
  double sum = 0.0;
  double weight = 0.0;
  for (const auto& term : strains) {
    if (model.terms[static_cast<std::size_t>(term.term)].strain.name != measure) continue;
    for (std::size_t k = 0; k < term.strain.size(); ++k) {
      sum += term.measure[k] * term.strain[k];
      weight += term.measure[k];
    }
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

/// The path of a frame's mean strain, as the curve of a material point.
void append_frame(const estimation::SequenceFrame& frame, const Eigen::Vector3d& q,
                  Curves& curves) {
  const auto f = static_cast<int>(curves.path.q.size());
  curves.path.q.push_back(q);
  curves.path.duration_s.push_back(f == 0 ? 0.0 : frame.duration_s);
  curves.path.start.push_back(f == 0 ? mechanics::FrameStart::virgin : mechanics::FrameStart::next);
  curves.clock_s.push_back((f == 0 ? 0.0 : curves.clock_s.back()) + curves.path.duration_s.back());
  curves.frame.push_back(f);
  curves.origin.push_back(f);
  if (curves.blocks.empty() || frame.block != curves.block_of.back())
    curves.blocks.push_back({0, capture::Branch::other, f, f});
  curves.blocks.back().last = f + 1;
  curves.block_of.push_back(frame.block);
}

/// Blocks by their number in the curve, and those that do not move are holds.
void finish(Curves& curves) {
  for (std::size_t b = 0; b < curves.blocks.size(); ++b) {
    estimation::Block& block = curves.blocks[b];
    double move = 0.0;
    for (int f = block.first; f < block.last; ++f) {
      curves.block_of[static_cast<std::size_t>(f)] = static_cast<int>(b);
      move = std::max(move, (curves.path.q[static_cast<std::size_t>(f)] -
                             curves.path.q[static_cast<std::size_t>(block.first)])
                                .cwiseAbs()
                                .maxCoeff());
    }
    constexpr double kStill = 1e-5;
    if (block.last - block.first >= 3 && move < kStill) block.branch = capture::Branch::hold;
  }
  curves.runs = {{1, curves.title, 0, static_cast<int>(curves.path.q.size())}};
}

/// Forces, and whether points are hidden.
void add_seen(const estimation::Sequence& sequence, SheetExcitation& sheet) {
  sheet.captures.push_back(sequence.name);
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    double largest = 0.0;
    for (const auto& frame : sequence.frames)
      if (std::isfinite(frame.forces_N[static_cast<Eigen::Index>(k)]))
        largest = std::max(largest, frame.forces_N[static_cast<Eigen::Index>(k)]);
    sheet.forces.push_back({sequence.forces[k].name, sequence.name, largest,
                            static_cast<int>(sequence.frames.size())});
  }
  for (const auto& frame : sequence.frames) {
    const auto not_seen = (frame.points_m.array() != frame.points_m.array()).count();
    sheet.has_hidden =
        sheet.has_hidden || not_seen > 3 * static_cast<Eigen::Index>(frame.misread.size());
  }
}

/// Adds min(|eps_1|, |eps_2|) of every element to a histogram.
void add_together(const mechanics::TermStrains& term, StrainHistogram& histogram) {
  for (std::size_t k = 0; 2 * k + 1 < term.strain.size(); ++k)
    histogram.add(std::min(std::abs(term.strain[2 * k]), std::abs(term.strain[2 * k + 1])),
                  term.measure[k]);
}

}  // namespace

Expected<Excitation> examine_sheets(const FieldData& data, const FieldStates& states) {
  const model::Model model = probe();
  std::vector<StrainHistogram> all(model.terms.size());
  std::vector<StrainHistogram> together(model.terms.size());
  std::vector<Curves> means;
  SheetExcitation sheet;
  sheet.lo_m.setConstant(1e300);
  sheet.hi_m.setConstant(-1e300);
  std::vector<mechanics::TermStrains> strains;
  for (std::size_t s = 0; s < states.size(); ++s) {
    const estimation::Sequence& sequence = data.sequences[s];
    const auto mesh = mechanics::MeshModel::make(model, sequence.cloth);
    if (!mesh) return tl::unexpected(mesh.error());
    Curves curves;
    curves.id = data.ids[s];
    curves.title = sequence.name;
    curves.time_base = data.has_clock[s] ? estimation::TimeBase::clock : estimation::TimeBase::none;
    for (std::size_t f = 0; f < states[s].size(); ++f) {
      if (mesh->term_strains(states[s][f].x, strains) != mechanics::AssemblyStatus::ok) continue;
      append_frame(sequence.frames[f],
                   {1.0 + mean_of(strains, model, "soft_u"),
                    1.0 + mean_of(strains, model, "soft_v"), mean_of(strains, model, "green_uv")},
                   curves);
      for (const auto& term : strains) {
        const auto t = static_cast<std::size_t>(term.term);
        const auto per = static_cast<std::size_t>(term.strains);
        for (std::size_t k = 0; k < term.strain.size(); ++k)
          all[t].add(term.strain[k], term.measure[k / per]);
        if (per == 2) add_together(term, together[t]);
      }
    }
    finish(curves);
    means.push_back(std::move(curves));
    add_seen(sequence, sheet);
    sheet.lo_m = sheet.lo_m.cwiseMin(sequence.cloth.mesh.material_m.rowwise().minCoeff());
    sheet.hi_m = sheet.hi_m.cwiseMax(sequence.cloth.mesh.material_m.rowwise().maxCoeff());
    sheet.hangs = sheet.hangs || sequence.loads.node_mass_kg.size() > 0;
  }
  Excitation e = examine(means);
  for (std::size_t t = 0; t < all.size(); ++t) {
    all[t].sort();
    together[t].sort();
    const std::string key = measure_key(model.terms[t].strain);
    const auto [lo, hi] = all[t].range(kOutliers);
    sheet.ranges[key] = {std::min(lo, 0.0), std::max(hi, 0.0)};
    if (!together[t].is_empty()) sheet.together[key] = together[t].quantile(1.0 - kOutliers);
  }
  const auto reach = [&](const char* measure, double angle) {
    const auto [lo, hi] = sheet.ranges.at(measure_key({measure, angle}));
    return std::max(-lo, hi);
  };
  e.weft = reach("green_u", 0.0);
  e.warp = reach("green_v", 0.0);
  e.shear = reach("green_uv", 0.0);
  e.diagonal = reach("green_fibre_pair", kDiagonal);
  e.large_strain = std::max(e.weft, e.warp) > 0.2;
  e.sheet = std::move(sheet);
  return e;
}

void adapt_ranges(model::Model& model, const Excitation& excitation) {
  for (model::Term& term : model.terms) {
    const model::LawRow* row = model::find_law(term.law.name);
    if (row == nullptr || !row->spline || term.law.range_hi > term.law.range_lo) continue;
    const auto [lo, hi] = range_of(excitation, term.strain);
    if (hi > lo) std::tie(term.law.range_lo, term.law.range_hi) = std::pair(lo, hi);
  }
}

}  // namespace tenter::diagnosis
