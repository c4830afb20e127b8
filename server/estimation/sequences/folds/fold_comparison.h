// SPDX-License-Identifier: GPL-3.0-or-later
// Measured and simulated folds of a frame side by side, and whether the distance of their points
// says anything (thesis 3.6).
//
//   likeness     correlation of the two reliefs w over the points: 1 the same folds in place,
//                0 none of them, -1 turned inside out
//   bending      share of bending in the elastic energy (terms on hinges and ring-2 springs)
//
// Point by point distances are meaningful where neither sheet is folded, or both alike (likeness
// 0.7 and above). Else the measures are what to compare.
//
//   auto folds = compare_folds(sequence, frame, state);
//   if (!is_meaningful(folds->positions)) report(words_of(folds->positions));
//   auto share = bending_share(model, mesh_model, parameters, state.x);
//
// Pure; callable from any thread.
#pragma once

#include <string_view>

#include "common/model/model.h"
#include "server/estimation/sequences/folds/fold_measure.h"
#include "server/estimation/sequences/sequence.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::estimation {

enum class PositionMeaning {
  no_folds,           ///< or lower than the noise: compare point by point
  folds_in_place,     ///< folded alike: compare point by point
  folds_elsewhere,    ///< folds of the same kind at other places: distances say nothing
  other_folds,        ///< other wavelength or direction: distances say nothing, the measures do
  only_one_is_folded  ///< one has folds, the other none
};
bool is_meaningful(PositionMeaning meaning);
/// One sentence for reports.
std::string_view words_of(PositionMeaning meaning);

struct FoldComparison {
  FoldMeasure measured, simulated;
  double likeness = 0.0;  ///< zero where neither is folded
  PositionMeaning positions = PositionMeaning::no_folds;
};

/// Both of the same material points. bad_input as measure_folds().
Expected<FoldComparison> compare_folds(const SheetPoints& measured, const SheetPoints& simulated,
                                       double sigma_m);

/// The points of a sequence's frame and where a simulated state has them. bad_input as above, a
/// frame that is none, and a state of another mesh.
Expected<FoldComparison> compare_folds(const Sequence& sequence, std::size_t frame,
                                       const mechanics::State& state);

/// 0 to 1, of `model` bound as `bound`. bad_input where it has no energy at x.
Expected<double> bending_share(const model::Model& model, const mechanics::MeshModel& bound,
                               const Eigen::VectorXd& parameters, const Eigen::VectorXd& x);

}  // namespace tenter::estimation
