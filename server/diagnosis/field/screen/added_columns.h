// SPDX-License-Identifier: GPL-3.0-or-later
// What would terms and sensor corrections that a model does not have do to what a sheet shows?
// Derivatives of every row by their parameters where they are switched off, through the
// equilibrium's own factor: no fit, and one factorisation a frame however many there are.
//
//   G = dPi/dx,  K dx/dq = -dG/dq          dm/dq = m_x . dx/dq + m_G . dG/dq
//
// A term that is off pulls nowhere and answers to nothing, so dG/dq of laws that remember their
// path is that along the path of the fitted frames as it stands; what the model's own memory makes
// of dx is carried along. A correction that only changes what is shown needs no dx; of the two that
// change the equilibrium (mass, slip) columns that a frame does not feel are not solved for. Exact,
// as sensitivity_along_path.
//
//   auto rows = added_columns(fit, data, {terms, fields, corrections, {0, 3}, {1}}, threads);
//
// Only what is wanted costs anything: parameters that a grid sets, or that answer to nothing where
// their term is off, are better not asked for. Pure; the same bytes for any number of threads.
// Threads take sequences.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/diagnosis/field/data/field_fit.h"

namespace tenter::diagnosis {

struct Added {
  std::vector<model::Term> terms;
  std::vector<model::Field> fields;  ///< that their supports refer to
  std::vector<model::SensorCorrection> corrections;
  /// Places among the parameters of all terms, and of all corrections, rising.
  std::vector<int> wanted_of_terms, wanted_of_corrections;

  Eigen::Index count() const {
    return static_cast<Eigen::Index>(wanted_of_terms.size() + wanted_of_corrections.size());
  }
};

/// Rows of the fit x what is wanted of terms, then of corrections. bad_input as MeshModel::make and
/// SequenceSensors::make; refused where a frame is no stable rest.
Expected<estimation::RowMatrix> added_columns(const FieldFit& fit, const FieldData& data,
                                              const Added& added, int threads);

}  // namespace tenter::diagnosis
