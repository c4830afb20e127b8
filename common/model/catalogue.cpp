// SPDX-License-Identifier: Apache-2.0
#include "common/model/catalogue.h"

#include <algorithm>
#include <cmath>

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

namespace {

/// N^newtons s^seconds m^metres for the few combinations that rows have.
std::string_view unit_of(bool energy, bool seconds, int metres) {
  struct Unit {
    bool energy, seconds;
    int metres;
    std::string_view text;
  };
  static constexpr Unit kUnits[] = {
      {true, false, -2, "N/m^2"},  {true, false, -1, "N/m"},  {true, false, 0, "N"},
      {true, false, 1, "N m"},     {true, false, 2, "N m^2"}, {true, false, 3, "N m^3"},
      {true, true, -2, "N s/m^2"}, {true, true, -1, "N s/m"}, {true, true, 1, "N s m"},
      {false, false, 0, "1"},      {false, false, -1, "1/m"}, {false, false, 2, "m^2"}};
  for (const Unit& unit : kUnits)
    if (unit.energy == energy && unit.seconds == seconds && unit.metres == metres) return unit.text;
  return "";
}

}  // namespace

std::string_view words_of(Domain domain) {
  switch (domain) {
    case Domain::membrane:
      return "membrane";
    case Domain::edge:
      return "edge";
    case Domain::hinge:
      return "hinge";
    case Domain::solid:
      return "solid";
  }
  return "";
}

std::string_view words_of(Seen seen) {
  return seen == Seen::curves ? "curves" : "sheets";
}

std::string_view energy_density_unit(Domain domain) {
  return domain == Domain::solid ? "J/m^3" : "J/m^2";
}

ParameterRow in_domain(const ParameterRow& row, Domain domain) {
  ParameterRow result = row;
  const bool energy = row.unit == "N/m" || row.unit == "N s/m";
  const bool seconds = row.unit == "N s/m";
  double scale = 1.0;
  if (domain == Domain::solid && energy) {
    scale = 1e3;
    result.unit = unit_of(true, seconds, -2);
  } else if (domain == Domain::hinge && (energy || row.per_strain != 0)) {
    constexpr double kCurvature = 1e3;
    scale = (energy ? 0.1 : 1.0) / std::pow(kCurvature, row.per_strain);
    result.unit = unit_of(energy, seconds, (energy ? -1 : 0) + row.per_strain);
  }
  result.value *= scale;
  if (result.lower) *result.lower *= scale;
  if (result.upper) *result.upper *= scale;
  return result;
}

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
      {"green_u_shear", 2, false, "Green-Lagrange strain along the weft and w_u . w_v, together"},
      {"green_v_shear", 2, false, "Green-Lagrange strain along the warp and w_u . w_v, together"},
      {"soft_u", 1, false, "engineering strain along the weft, |w_u| - 1"},
      {"soft_v", 1, false, "engineering strain along the warp, |w_v| - 1"},
      {"soft_pair", 2, false, "engineering strains along weft and warp, together"},
      {"spring_u", 1, false, "relative change of length of a spring along the weft", Domain::edge},
      {"spring_v", 1, false, "relative change of length of a spring along the warp", Domain::edge},
      {"spring_d1", 1, false, "relative change of length of a spring at +45 degrees", Domain::edge},
      {"spring_d2", 1, false, "relative change of length of a spring at -45 degrees", Domain::edge},
      {"fibre", 1, true, "engineering strain of a fibre at an angle from the weft, |F a| - 1"},
      {"green_fibre", 1, true, "Green-Lagrange strain of a fibre at an angle from the weft, (|F a|^2 - 1) / 2"},
      {"fibre_pair", 2, true, "engineering strains of the two fibres at plus and minus the angle"},
      {"green_fibre_pair", 2, true, "Green-Lagrange strains of the two fibres at plus and minus the angle"},
      {"area", 1, false, "relative change of area, J - 1"},
      {"green_square", 1, false, "trace of the square of the Green-Lagrange strain tensor"},
      {"principal_stretches", 2, false, "both principal stretches minus one, the larger first"},
      // name, strains, angle, words, domain, answers a homogeneous strain
      {"ring2_u", 1, false, "relative change of length of a spring along the weft that spans two edges", Domain::edge, false},
      {"ring2_v", 1, false, "relative change of length of a spring along the warp that spans two edges", Domain::edge, false},
      {"ring2_d", 1, false, "relative change of length of a diagonal spring that spans two edges", Domain::edge, false},
      {"bend_u", 1, false, "bending along the weft: change of dihedral angle over a third of the triangles' height", Domain::hinge, false},
      {"bend_v", 1, false, "bending along the warp: change of dihedral angle over a third of the triangles' height", Domain::hinge, false},
      {"bend_d", 1, false, "bending across diagonal edges: change of dihedral angle over a third of the triangles' height", Domain::hinge, false},
      {"solid_green_xx", 1, false, "Green-Lagrange strain along x, (C_xx - 1) / 2", Domain::solid, false},
      {"solid_green_yy", 1, false, "Green-Lagrange strain along y, (C_yy - 1) / 2", Domain::solid, false},
      {"solid_green_zz", 1, false, "Green-Lagrange strain along z, (C_zz - 1) / 2", Domain::solid, false},
      {"solid_green_yz", 1, false, "Green-Lagrange shear in y-z, C_yz", Domain::solid, false},
      {"solid_green_xz", 1, false, "Green-Lagrange shear in x-z, C_xz", Domain::solid, false},
      {"solid_green_xy", 1, false, "Green-Lagrange shear in x-y, C_xy", Domain::solid, false},
      {"solid_green_normal", 3, false, "Green-Lagrange strains along x, y and z, together", Domain::solid, false},
      {"solid_green_shear", 3, false, "Green-Lagrange shears in y-z, x-z and x-y, together", Domain::solid, false},
      {"solid_green_trace", 1, false, "trace of the Green-Lagrange strain tensor of a solid", Domain::solid, false},
      {"solid_green_square", 1, false, "trace of the square of the Green-Lagrange strain tensor of a solid", Domain::solid, false},
      {"solid_invariant_1", 1, false, "first invariant of C minus 3", Domain::solid, false},
      {"solid_invariant_2", 1, false, "second invariant of C minus 3", Domain::solid, false},
      {"solid_isochoric_1", 1, false, "first invariant of C without its change of volume, I_1 J^(-2/3) - 3", Domain::solid, false},
      {"solid_isochoric_2", 1, false, "second invariant of C without its change of volume, I_2 J^(-4/3) - 3", Domain::solid, false},
      {"solid_log_volume", 1, false, "logarithm of the relative volume, ln J", Domain::solid, false},
      {"solid_volume", 1, false, "relative change of volume, J - 1", Domain::solid, false},
      {"solid_neo_hookean", 1, false, "I_1 - 3 - 2 ln J, which is at rest without stress", Domain::solid, false},
      {"solid_principal_stretches", 3, false, "the three principal stretches minus one, the largest first", Domain::solid, false},
      {"solid_fibre", 1, true, "engineering strain of a fibre of a solid, |F a| - 1", Domain::solid, false},
      {"solid_green_fibre", 1, true, "Green-Lagrange strain of a fibre of a solid, (|F a|^2 - 1) / 2", Domain::solid, false},
  };
  return rows;
}

const std::vector<LawRow>& law_catalogue() {
  static const std::vector<LawRow> rows = {
      // name, strains, spline, fewest points, path, rate, {{parameter, unit, lower, upper, default, fixed, per strain}...}, words
      {"linear", 0, false, 0, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}}, "constant stiffness: energy k/2 |eps|^2"},
      {"linear_stiffness", 0, false, 0, false, false, {{"k1", "N/m", 0.0, kNone, 100.0, false, 2}, {"k2", "N/m", kNone, kNone, 0.0, false, 3}}, "stiffness linear in the strain: stress (k1 + k2 |eps|) eps (thesis 5.3.2)"},
      {"bilinear", 2, false, 0, false, false, {{"c", "N/m", kNone, kNone, 10.0, false, 2}}, "coupling of two strains: energy c eps_1 eps_2"},
      {"hermite_stiffness", 0, true, 1, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}}, "stress k(eps) eps with k a Hermite spline through non-negative control points (thesis 3.3.2)"},
      {"bspline_stiffness", 0, true, 1, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}}, "stress k(eps) eps with k a B-spline of non-negative coefficients, cubic from four of them on"},
      {"convex_spline", 0, true, 2, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}}, "tangent stiffness a non-negative B-spline and stress its integral: a convex energy"},
      {"constant_stress", 1, false, 0, false, false, {{"c", "N/m", kNone, kNone, 10.0, false, 1}}, "energy c eps: prestress and rest curvature, or for strains that are energies already"},
      {"ogden", 0, false, 0, false, false, {{"mu", "N/m", kNone, kNone, 50.0}, {"alpha", "1", -32.0, 32.0, 2.0}}, "energy mu ((1 + eps)^alpha - 1)/alpha - mu ln(1 + eps) of each stretch (Ogden)"},
      {"hermite_energy", 1, true, 2, false, false, {{"w", "N/m", kNone, kNone, 0.0}}, "energy a Hermite spline through control points (thesis 4.2)"},
      {"gaussian_energy", 1, true, 2, false, false, {{"w", "N/m", kNone, kNone, 0.0}}, "energy a sum of Gaussians with even centres (thesis 4.2)"},
      {"gaussian_energy_2", 2, true, 4, false, false, {{"w", "N/m", kNone, kNone, 0.0}}, "energy of two strains, a sum of Gaussians on a square grid of centres (thesis 4.2)", true},
      {"exponential_fibre", 1, false, 0, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}, {"beta", "1", 0.0, kNone, 1.0, false, 2}}, "fibre that stiffens exponentially with its strain"},
      {"dahl", 0, false, 0, true, false, {{"a", "N/m", 0.0, kNone, 1.0, false, 1}, {"b", "N/m", 0.0, kNone, 1.0, false, 2}, {"c", "N/m", 0.0, kNone, 0.0, true, 3}, {"tau", "1", 1e-6, kNone, 0.01, false, -1}}, "internal friction after Dahl, sigma_max = a + b |eps| + c eps^2, reached over the strain tau (thesis 5.2)"},
      {"dahl_linearised", 1, false, 0, true, false, {{"a", "N/m", 0.0, kNone, 1.0, false, 1}, {"b", "N/m", 0.0, kNone, 1.0, false, 2}, {"c", "N/m", 0.0, kNone, 0.0, true, 3}, {"tau", "1", 1e-6, kNone, 0.01, false, -1}}, "dahl with a stress that is linear within a time step, to compare with (thesis 5.9)"},
      {"maxwell", 0, false, 0, true, true, {{"k", "N/m", 0.0, kNone, 10.0, false, 2}, {"relaxation_time", "s", 1e-6, kNone, 1.0}}, "spring and dashpot in series: stress that relaxes in a hold"},
      {"kelvin_voigt", 0, false, 0, true, true, {{"eta", "N s/m", 0.0, kNone, 1.0, false, 2}}, "dashpot beside the other terms: stress eta times strain rate"},
      {"plastic_set", 1, false, 0, true, false, {{"c", "N/m", 0.0, kNone, 10.0, false, 2}, {"yield_strain", "1", 0.0, kNone, 0.05, false, -1}}, "strain beyond the yield strain that stays, growing with new maxima only"},
      {"plastic_set_coupled", 2, false, 0, true, false, {{"c", "N/m", 0.0, kNone, 10.0, false, 2}, {"coupling", "N/m", kNone, kNone, 0.0, false, 2}, {"yield_strain", "1", 0.0, kNone, 0.05, false, -1}}, "plastic set of the first strain that also shifts the stress of the second"},
      {"softening", 1, false, 0, true, false, {{"k", "N/m", 0.0, kNone, 10.0, false, 2}, {"strain_scale", "1", 1e-6, kNone, 0.1, false, -1}, {"power", "1", 1.0, 8.0, 1.0, true}}, "stress k eps^power that the first loading to each new maximum had and later ones lose (Mullins)"},
      {"cross_modal", 2, false, 0, false, false, {{"c", "N/m", 0.0, kNone, 1e4, false, 4}}, "each of two strains stiffens the other: energy c/2 eps_1^2 eps_2^2 (thesis table 4.1)"},
      {"strain_limit", 0, false, 0, false, false, {{"k", "N/m", 0.0, kNone, 100.0, false, 2}, {"limit", "1", 1e-6, kNone, 0.05, false, -1}}, "sudden stiffening: energy k/2 (|eps| - limit)^2 beyond the limit, nothing below it"},
  };
  return rows;
}

const std::vector<CorrectionRow>& correction_catalogue() {
  static const std::vector<CorrectionRow> rows = {
      // name, {{parameter, unit, lower, upper, default, fixed}...}, words, of what
      {"offset", {{"value", "N/m", kNone, kNone, 0.0}}, "the channel shows a constant too much"},
      {"gain", {{"value", "1", 0.0, kNone, 1.0}}, "the channel shows a multiple of the true value"},
      {"drift", {{"rate", "N/(m s)", kNone, kNone, 0.0}}, "the channel's zero moves with the clock"},
      {"delay", {{"value", "s", kNone, kNone, 0.0}}, "the channel shows the value of a moment earlier (later where negative)"},
      {"clip_slip", {{"step", "N/m", kNone, kNone, 0.0}, {"at_frame", "1", 0.0, kNone, 0.0, true}}, "the force steps at a frame because a clip slipped"},
      {"cord_friction", {{"mu", "1", 0.0, 1.0, 0.0}}, "the channel shows a share of the tension more while its strain grows, less while it falls"},
      {"saturation", {{"share", "1", 0.0, 2.0, 0.0}, {"cap", "N/m", kNone, kNone, 0.0}}, "the channel loses a share of what is above a cap; 1: a flat top"},
      {"camera_scale", {{"scale", "1", 0.0, kNone, 1.0}}, "the observed change of length is shown times a factor"},
      {"camera_length", {{"scale", "1", 0.0, kNone, 1.0}}, "the observed length is shown times a factor, also at rest"},
      {"offset", {{"value", "N", kNone, kNone, 0.0}}, "the channel shows a constant force too much", Seen::sheets},
      {"gain", {{"value", "1", 0.0, kNone, 1.0}}, "the channel shows a multiple of the true force", Seen::sheets},
      {"drift", {{"rate", "N/s", kNone, kNone, 0.0}}, "the channel's zero moves with the clock", Seen::sheets},
      {"delay", {{"value", "s", kNone, kNone, 0.0}}, "the channel shows the force of a moment earlier than the frame (later where negative)", Seen::sheets},
      {"cord_friction", {{"mu", "1", 0.0, 1.0, 0.0}}, "the channel shows a share of the force more while its clip moves along it, less while it moves back", Seen::sheets},
      {"saturation", {{"share", "1", 0.0, 2.0, 0.0}, {"cap", "N", kNone, kNone, 0.0}}, "the channel loses a share of what is above a cap; 1: a flat top", Seen::sheets},
      {"camera_scale", {{"scale", "1", 0.0, kNone, 1.0}}, "points are shown a factor further from the middle of what the first frame saw", Seen::sheets},
      {"camera_pose", {{"turn_x", "rad", kNone, kNone, 0.0}, {"turn_y", "rad", kNone, kNone, 0.0}, {"turn_z", "rad", kNone, kNone, 0.0}, {"shift_x", "m", kNone, kNone, 0.0}, {"shift_y", "m", kNone, kNone, 0.0}, {"shift_z", "m", kNone, kNone, 0.0}}, "points are shown turned by a vector about the middle of what the first frame saw, and shifted: a camera that was moved", Seen::sheets},
      {"occlusion_bias", {{"length", "m", kNone, kNone, 0.0}, {"reach", "1", 0.0, kNone, 1.5, true}}, "points beside hidden ones are shown nearer to the camera by a length, those further away than a reach in spacings of the points by ever less", Seen::sheets},
      {"clip_slip", {{"length", "m", kNone, kNone, 0.0}, {"at_frame", "1", 0.0, kNone, 0.0, true}}, "from a frame on the cloth has slipped out of a clip by a length, against its pull", Seen::sheets},
      {"mass_scale", {{"scale", "1", 0.0, kNone, 1.0}}, "the sheet weighs a multiple of what was measured", Seen::sheets},
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
const CorrectionRow* find_correction(std::string_view name, Seen seen) {
  for (const CorrectionRow& row : correction_catalogue())
    if (row.name == name && row.seen == seen) return &row;
  return nullptr;
}

bool fits(const SensorCorrection& correction, const CorrectionRow& row) {
  return correction.type == row.name &&
         std::equal(correction.parameters.begin(), correction.parameters.end(),
                    row.parameters.begin(), row.parameters.end(),
                    [](const Parameter& parameter, const ParameterRow& expected) {
                      return parameter.name == expected.name && parameter.unit == expected.unit;
                    });
}

std::vector<Parameter> default_parameters(const LawRow& law, int control_points, Domain domain) {
  std::vector<Parameter> parameters;
  if (!law.spline) {
    for (const ParameterRow& row : law.parameters)
      parameters.push_back(default_parameter(in_domain(row, domain)));
    return parameters;
  }
  const ParameterRow row = in_domain(law.parameters.front(), domain);
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

std::pair<double, double> spline_range(const Law& law, Domain domain) {
  if (law.range_lo == law.range_hi)
    return domain == Domain::hinge ? std::pair{-300.0, 300.0} : std::pair{0.0, 0.5};
  return {law.range_lo, law.range_hi};
}

bool may_have_knots(const Law& law) {
  return law.name == "hermite_stiffness" || law.name == "bspline_stiffness" ||
         law.name == "convex_spline";
}

int spline_pieces(const Law& law, int points) {
  return std::max(1,
                  law.name == "hermite_stiffness" ? points - 1 : points - std::min(3, points - 1));
}

std::vector<double> spline_knots(const Law& law, Domain domain) {
  const auto [lo, hi] = spline_range(law, domain);
  const int pieces = spline_pieces(law, static_cast<int>(law.parameters.size()));
  std::vector<double> knots = {lo};
  for (int i = 1; i < pieces; ++i)
    knots.push_back(law.knots.empty() ? lo + i * ((hi - lo) / pieces)
                                      : law.knots[static_cast<std::size_t>(i - 1)]);
  knots.push_back(hi);
  return knots;
}

bool remembers_path(const Model& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const Term& term) {
    const LawRow* row = find_law(term.law.name);
    return row != nullptr && row->path_dependent;
  });
}

}  // namespace tenter::model
