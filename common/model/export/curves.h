// SPDX-License-Identifier: Apache-2.0
// The curves of a model as tables that any program reads: stress and tangent stiffness of each term
// over its strain, with the band of its intervals and the range of strains that the data reached.
//
//   band: every parameter anywhere in its 95 % interval,   lo = sum_j min(phi_j p_lo, phi_j p_hi)
//
// so it holds every curve whose parameters all lie in their intervals; it is wider than a 95 % band
// of the curve. It is empty where a parameter that is not fixed has no interval. Outside of the
// range that the data reached a curve is the law's continuation, not a finding.
//
//   write_curves_csv(model)   one row a sample, one header line
//   write_curves_json(model)  schema "tenter.curves": units, intervals, ranges, samples, and the
//                             whole model document, so that nothing is lost
//   read_curves_json(text)    the model that such a file holds
//
// Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::model {

/// What another format could not take is in `losses`, a sentence each.
struct Exported {
  std::string text;
  std::vector<std::string> losses;
};

struct Band {
  std::vector<double> value;
  std::vector<double> lo;  ///< empty: not known
  std::vector<double> hi;
};

struct CurveTable {
  std::string term;
  std::string strain_measure;
  std::string strain_unit;
  std::string stress_unit;
  std::string stiffness_unit;
  std::vector<double> strain;
  Band stress;
  Band stiffness;
  std::optional<std::pair<double, double>> reached;  ///< by the data; none: the model does not say
};

struct CurveSet {
  std::vector<CurveTable> curves;
  std::vector<std::string> left_out;  ///< terms without a curve, a sentence each
};

/// `samples` >= 2 even strains over what the data reached and the control points span. The model
/// must be valid.
CurveSet curves_of(const Model& model, int samples = 101);

/// bad_input where no term has a curve.
Expected<Exported> write_curves_csv(const Model& model, int samples = 101);

Exported write_curves_json(const Model& model, int samples = 101);
Expected<Model> read_curves_json(std::string_view text, std::string_view source_name);

}  // namespace tenter::model
