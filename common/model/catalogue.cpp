// SPDX-License-Identifier: Apache-2.0
#include "common/model/catalogue.h"

namespace tenter::model {

namespace {

constexpr std::optional<double> kNone = std::nullopt;

template <class Row>
const Row* find_row(const std::vector<Row>& rows, std::string_view name) {
  for (const Row& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

Parameter default_parameter(const ParameterRow& row) {
  Parameter parameter;
  parameter.name = row.name;
  parameter.value = row.value;
  parameter.unit = row.unit;
  parameter.lower = row.lower;
  parameter.upper = row.upper;
  parameter.fixed = row.fixed;
  return parameter;
}

}  // namespace

// One line per row, however long.
// clang-format off

const std::vector<StrainRow>& strain_catalogue() {
  static const std::vector<StrainRow> rows = {
      // name, strains, angle, words
      {"green_u", 1, false, "Green-Lagrange strain along the weft, (|w_u|^2 - 1) / 2"},
      {"green_v", 1, false, "Green-Lagrange strain along the warp, (|w_v|^2 - 1) / 2"},
      {"green_uv", 1, false, "Green-Lagrange shear, w_u . w_v"},
      {"green_trace", 1, false, "sum of the Green-Lagrange strains along weft and warp"},
      {"green_deviator", 2, false, "difference of the Green-Lagrange strains along weft and warp, and w_u . w_v"},
      {"green_pair", 2, false, "Green-Lagrange strains along weft and warp, together"},
      {"green_pair_vu", 2, false, "Green-Lagrange strains along warp and weft, together, warp first"},
      {"soft_u", 1, false, "engineering strain along the weft, |w_u| - 1"},
      {"soft_v", 1, false, "engineering strain along the warp, |w_v| - 1"},
      {"soft_pair", 2, false, "engineering strains along weft and warp, together"},
      {"spring_u", 1, false, "relative change of length of a spring along the weft"},
      {"spring_v", 1, false, "relative change of length of a spring along the warp"},
      {"spring_d1", 1, false, "relative change of length of a spring at +45 degrees"},
      {"spring_d2", 1, false, "relative change of length of a spring at -45 degrees"},
      {"fibre", 1, true, "engineering strain of a fibre at an angle from the weft, |F a| - 1"},
      {"green_fibre", 1, true, "Green-Lagrange strain of a fibre at an angle from the weft, (|F a|^2 - 1) / 2"},
      {"fibre_pair", 2, true, "engineering strains of the two fibres at plus and minus the angle"},
      {"green_fibre_pair", 2, true, "Green-Lagrange strains of the two fibres at plus and minus the angle"},
      {"area", 1, false, "relative change of area, J - 1"},
  };
  return rows;
}

const std::vector<LawRow>& law_catalogue() {
  static const std::vector<LawRow> rows = {
      // name, strains, spline, fewest points, path, rate, {{parameter, unit, lower, upper, default, fixed}...}, words
      {"linear", 0, false, 0, false, false, {{"k", "N/m", 0.0, kNone, 100.0}}, "constant stiffness: energy k/2 |eps|^2"},
      {"bilinear", 2, false, 0, false, false, {{"c", "N/m", kNone, kNone, 10.0}}, "coupling of two strains: energy c eps_1 eps_2"},
      {"hermite_stiffness", 0, true, 1, false, false, {{"k", "N/m", 0.0, kNone, 100.0}}, "stress k(eps) eps with k a Hermite spline through non-negative control points (thesis 3.3.2)"},
      {"bspline_stiffness", 0, true, 4, false, false, {{"k", "N/m", 0.0, kNone, 100.0}}, "stress k(eps) eps with k a cubic B-spline of non-negative coefficients"},
      {"convex_spline", 0, true, 2, false, false, {{"k", "N/m", 0.0, kNone, 100.0}}, "tangent stiffness a non-negative B-spline and stress its integral: a convex energy"},
      {"exponential_fibre", 1, false, 0, false, false, {{"k", "N/m", 0.0, kNone, 100.0}, {"beta", "1", 0.0, kNone, 1.0}}, "fibre that stiffens exponentially with its strain"},
      {"dahl", 0, false, 0, true, false, {{"a", "N/m", 0.0, kNone, 1.0}, {"b", "N/m", 0.0, kNone, 1.0}, {"c", "N/m", 0.0, kNone, 0.0, true}, {"tau", "1", 1e-6, kNone, 0.01}}, "internal friction after Dahl, sigma_max = a + b |eps| + c eps^2, reached over the strain tau (thesis 5.2)"},
      {"maxwell", 0, false, 0, true, true, {{"k", "N/m", 0.0, kNone, 10.0}, {"relaxation_time", "s", 1e-6, kNone, 1.0}}, "spring and dashpot in series: stress that relaxes in a hold"},
      {"kelvin_voigt", 0, false, 0, true, true, {{"eta", "N s/m", 0.0, kNone, 1.0}}, "dashpot beside the other terms: stress eta times strain rate"},
      {"plastic_set", 1, false, 0, true, false, {{"c", "N/m", 0.0, kNone, 10.0}, {"yield_strain", "1", 0.0, kNone, 0.05}}, "strain beyond the yield strain that stays, growing with new maxima only"},
      {"plastic_set_coupled", 2, false, 0, true, false, {{"c", "N/m", 0.0, kNone, 10.0}, {"coupling", "N/m", kNone, kNone, 0.0}, {"yield_strain", "1", 0.0, kNone, 0.05}}, "plastic set of the first strain that also shifts the stress of the second"},
      {"softening", 1, false, 0, true, false, {{"k", "N/m", 0.0, kNone, 10.0}, {"strain_scale", "1", 1e-6, kNone, 0.1}, {"power", "1", 1.0, 8.0, 1.0, true}}, "stress k eps^power that the first loading to each new maximum had and later ones lose (Mullins)"},
  };
  return rows;
}

const std::vector<CorrectionRow>& correction_catalogue() {
  static const std::vector<CorrectionRow> rows = {
      // name, {{parameter, unit, lower, upper, default, fixed}...}, words
      {"offset", {{"value", "N/m", kNone, kNone, 0.0}}, "the channel shows a constant too much"},
      {"gain", {{"value", "1", 0.0, kNone, 1.0}}, "the channel shows a multiple of the true value"},
      {"drift", {{"rate", "N/(m s)", kNone, kNone, 0.0}}, "the channel's zero moves with the clock"},
      {"delay", {{"value", "s", kNone, kNone, 0.0}}, "the channel shows the value of a moment earlier (later where negative)"},
      {"clip_slip", {{"step", "N/m", kNone, kNone, 0.0}, {"at_frame", "1", 0.0, kNone, 0.0, true}}, "the force steps at a frame because a clip slipped"},
  };
  return rows;
}

// clang-format on

const StrainRow* find_strain(std::string_view name) {
  return find_row(strain_catalogue(), name);
}
const LawRow* find_law(std::string_view name) {
  return find_row(law_catalogue(), name);
}
const CorrectionRow* find_correction(std::string_view name) {
  return find_row(correction_catalogue(), name);
}

std::vector<Parameter> default_parameters(const LawRow& law, int control_points) {
  std::vector<Parameter> parameters;
  if (!law.spline) {
    for (const ParameterRow& row : law.parameters) parameters.push_back(default_parameter(row));
    return parameters;
  }
  const ParameterRow& row = law.parameters.front();
  for (int i = 1; i <= control_points; ++i) {
    parameters.push_back(default_parameter(row));
    parameters.back().name += std::to_string(i);
  }
  return parameters;
}

std::vector<Parameter> default_parameters(const CorrectionRow& correction) {
  std::vector<Parameter> parameters;
  for (const ParameterRow& row : correction.parameters)
    parameters.push_back(default_parameter(row));
  return parameters;
}

std::pair<double, double> spline_range(const Law& law) {
  if (law.range_lo == law.range_hi) return {0.0, 0.5};
  return {law.range_lo, law.range_hi};
}

}  // namespace tenter::model
