// SPDX-License-Identifier: GPL-3.0-or-later
// The twelve models that thesis 3.5 compares, and the rows of its Tables A.1 to A.4.
//
//   springs, soft constraints, diagonalised St. Venant-Kirchhoff
//     x  constant stiffness or curves  x  one curve for weft and warp (isotropic) or two
//
//   for (const Variant& variant : all_variants()) {
//     const VariantModel form = variant_model(variant);
//     auto row = appendix_row(variant, training, others, options);
//   }
//
// Shear springs on both diagonals always share their curve. Pure.
#pragma once

#include "server/estimation/staged/staged_fit.h"
#include "server/estimation/staged/tables/scenario_residual.h"

namespace tenter::estimation {

enum class ClothModel { springs, soft_constraints, stvk };

struct Variant {
  ClothModel cloth = ClothModel::stvk;
  bool is_nonlinear = true;
  bool is_isotropic = false;
  std::string curves =
      {};  ///< law of the nonlinear ones, e.g. "hermite_stiffness"; empty: presets'
};

/// In the order of the tables: nonlinear before linear, orthotropic before isotropic.
std::vector<Variant> all_variants();
std::string words_of(const Variant& variant);  ///< "Non-Linear Ortho."
std::string words_of(ClothModel cloth);        ///< "Soft. Const."

struct VariantModel {
  model::Model model;                          ///< from the presets
  std::vector<std::vector<std::string>> ties;  ///< terms that share a curve
};
VariantModel variant_model(const Variant& variant);

struct AppendixRow {
  Variant variant;
  StagedResult fit;
  std::vector<ScenarioResidual> training;
  std::vector<ScenarioResidual> others;  ///< held out; specimens that were not fitted
};

/// A staged fit of the variant to `training`, and its residuals there and on `others`. `options`:
/// the ties are the variant's. Errors as staged_fit() and scenario_residual().
Expected<AppendixRow> appendix_row(const Variant& variant,
                                   const std::vector<RoleSequence>& training,
                                   const std::vector<RoleSequence>& others, StagedOptions options);

}  // namespace tenter::estimation
