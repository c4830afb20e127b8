// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/folds/fold_comparison.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/model/catalogue.h"
#include "server/estimation/sequences/material/material_locator.h"

namespace tenter::estimation {

namespace {

/// Between two directions that have no sense, 0 to pi / 2.
double angle_between(double a_rad, double b_rad) {
  const double off = std::fmod(std::abs(a_rad - b_rad), std::numbers::pi);
  return std::min(off, std::numbers::pi - off);
}

PositionMeaning meaning_of(const FoldComparison& folds) {
  const FoldMeasure &a = folds.measured, &b = folds.simulated;
  constexpr double kAlike = 0.7, kSameWavelength = 1.25, kSameDirection_rad = 0.26;
  if (!a.is_folded && !b.is_folded) return PositionMeaning::no_folds;
  if (a.is_folded != b.is_folded) return PositionMeaning::only_one_is_folded;
  if (folds.likeness >= kAlike) return PositionMeaning::folds_in_place;
  const double ratio =
      std::max(a.wavelength_m, b.wavelength_m) / std::min(a.wavelength_m, b.wavelength_m);
  // folds without a direction of their own have none to differ in
  constexpr double kAligned = 0.3;
  const bool same_direction = std::min(a.alignment, b.alignment) < kAligned ||
                              angle_between(a.direction_rad, b.direction_rad) <= kSameDirection_rad;
  return ratio <= kSameWavelength && same_direction ? PositionMeaning::folds_elsewhere
                                                    : PositionMeaning::other_folds;
}

}  // namespace

bool is_meaningful(PositionMeaning meaning) {
  return meaning == PositionMeaning::no_folds || meaning == PositionMeaning::folds_in_place;
}

std::string_view words_of(PositionMeaning meaning) {
  switch (meaning) {
    case PositionMeaning::no_folds:
      return "no folds: distances of points are meaningful";
    case PositionMeaning::folds_in_place:
      return "folds at the same places: distances of points are meaningful";
    case PositionMeaning::folds_elsewhere:
      return "the same folds at other places: distances of points say nothing";
    case PositionMeaning::other_folds:
      return "other folds: compare height, wavelength and direction, not distances of points";
    case PositionMeaning::only_one_is_folded:
      return "only one of measured and simulated is folded: distances of points say nothing";
  }
  return "";
}

Expected<FoldComparison> compare_folds(const SheetPoints& measured, const SheetPoints& simulated,
                                       double sigma_m) {
  if (measured.material_m.cols() != simulated.material_m.cols())
    return bad_input("folds: " + std::to_string(simulated.material_m.cols()) +
                     " simulated points beside " + std::to_string(measured.material_m.cols()) +
                     " measured ones");
  FoldComparison result;
  auto seen = measure_folds(measured, sigma_m);
  if (!seen) return tl::unexpected(seen.error());
  auto made = measure_folds(simulated, 0.0);
  if (!made) return tl::unexpected(made.error());
  result.measured = std::move(*seen);
  result.simulated = std::move(*made);
  // a fold too low to be seen under the noise is none
  if (!result.measured.is_folded && result.simulated.height_m < sigma_m)
    result.simulated.is_folded = false;
  // nor do folds lower than it, in both, move a point farther than it does
  if (std::max(result.measured.height_m, result.simulated.height_m) < sigma_m)
    result.measured.is_folded = result.simulated.is_folded = false;
  const Eigen::VectorXd &a = result.measured.relief_m, &b = result.simulated.relief_m;
  const double sizes = a.norm() * b.norm();
  if ((result.measured.is_folded || result.simulated.is_folded) && sizes > 0.0)
    result.likeness = a.dot(b) / sizes;
  result.positions = meaning_of(result);
  return result;
}

Expected<FoldComparison> compare_folds(const Sequence& sequence, std::size_t frame,
                                       const mechanics::State& state) {
  const auto& mesh = sequence.cloth.mesh;
  if (frame >= sequence.frames.size() || state.x.size() != 3 * mesh.node_count())
    return bad_input("folds: frame " + std::to_string(frame + 1) + " of " +
                     std::to_string(sequence.frames.size()) + ", " +
                     std::to_string(state.x.size() / 3) + " nodes of " +
                     std::to_string(mesh.node_count()));
  const auto count = static_cast<Eigen::Index>(sequence.points.size());
  const MaterialLocator locator(mesh);
  SheetPoints measured{Eigen::Matrix2Xd(2, count), sequence.frames[frame].points_m};
  SheetPoints simulated{Eigen::Matrix2Xd(2, count), measured.position_m};
  double variance_m2 = 0.0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const PointChannel& point = sequence.points[static_cast<std::size_t>(k)];
    measured.material_m.col(k) = simulated.material_m.col(k) = point.material_m;
    variance_m2 += point.sigma_m * point.sigma_m / static_cast<double>(count);
    // what was not seen is compared in neither
    const auto place = locator.locate(point.material_m);
    if (!place) return bad_input("folds: a point lies outside of the mesh");
    if (measured.position_m.col(k).allFinite())
      simulated.position_m.col(k) = place->position(state.x);
  }
  return compare_folds(measured, simulated, std::sqrt(variance_m2));
}

Expected<double> bending_share(const model::Model& model, const mechanics::MeshModel& bound,
                               const Eigen::VectorXd& parameters, const Eigen::VectorXd& x) {
  Eigen::VectorXd energies;
  if (bound.term_energies(x, parameters, energies) != mechanics::AssemblyStatus::ok)
    return bad_input("folds: the model has no energy here");
  double bending = 0.0;
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    const model::StrainRow* row = model::find_strain(model.terms[t].strain.name);
    const bool bends =
        row && (row->domain == model::Domain::hinge || row->name.starts_with("ring2"));
    if (bends) bending += energies[static_cast<Eigen::Index>(t)];
  }
  const double whole = energies.sum();
  return whole > 0.0 ? bending / whole : 0.0;
}

}  // namespace tenter::estimation
