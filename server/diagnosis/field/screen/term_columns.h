// SPDX-License-Identifier: GPL-3.0-or-later
// What would terms that a model does not have do to what a sheet shows? Derivatives of every row by
// their parameters where they are switched off, through the equilibrium's own factor: no fit, and
// one factorisation a frame however many terms there are.
//
//   G = dPi/dx,  K dx/dq = -dG/dq          dm/dq = m_x . dx/dq + m_G . dG/dq
//
// A term that is off pulls nowhere and answers to nothing, so dG/dq of laws that remember their
// path is that along the path of the fitted frames as it stands; what the model's own memory makes
// of dx is carried along. Exact, as sensitivity_along_path.
//
//   auto columns = term_columns(fit, data, gathering.added_terms(), threads);
//
// Pure; the same bytes for any number of threads. Threads take sequences.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "server/diagnosis/field/data/field_fit.h"

namespace tenter::diagnosis {

/// Rows of the fit x parameters of sensor corrections that are off, in their order; zero where one
/// is fixed. One evaluation of the fitted model with all of them. bad_input as
/// SequenceEvaluator::make.
Expected<Eigen::MatrixXd> correction_columns(
    const FieldFit& fit, const FieldData& data,
    const std::vector<model::SensorCorrection>& corrections, int threads);

/// Rows of the fit x parameters of the terms in their order; zero where a parameter is fixed.
/// bad_input as MeshModel::make; refused where a frame is no stable rest.
Expected<Eigen::MatrixXd> term_columns(const FieldFit& fit, const FieldData& data,
                                       const std::vector<model::Term>& terms,
                                       const std::vector<model::Field>& fields, int threads);

}  // namespace tenter::diagnosis
