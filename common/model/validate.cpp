// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <set>

#include "common/base/sha256.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string at(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

bool is_identifier(const std::string& text) {
  if (text.empty() || text.size() > 128) return false;
  for (const char c : text)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
          c == '-' || c == '.'))
      return false;
  return true;
}

/// Names are for people: any text of one line.
bool is_one_line(const std::string& text) {
  if (text.empty() || text.size() > 200) return false;
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  return true;
}

constexpr const char* kIdentifierRule = "must be 1 to 128 letters, digits, '_', '-' or '.'";

Expected<void> check_bounds(const Parameter& parameter, const ParameterRow& row,
                            const std::string& path) {
  const std::pair<const char*, const std::optional<double>*> numbers[] = {
      {"min", &parameter.lower},
      {"max", &parameter.upper},
      {"std_error", &parameter.std_error},
      {"interval", &parameter.interval_lo},
      {"interval", &parameter.interval_hi}};
  if (!std::isfinite(parameter.value)) return bad_input(path + ".value: must be a finite number");
  for (const auto& [key, value] : numbers)
    if (*value && !std::isfinite(**value))
      return bad_input(path + "." + key + ": must be a finite number");

  if (row.lower && parameter.lower && *parameter.lower < *row.lower)
    return bad_input(path + ".min: is " + number(*parameter.lower) + ", but the law allows " +
                     number(*row.lower) + " at the least");
  if (row.upper && parameter.upper && *parameter.upper > *row.upper)
    return bad_input(path + ".max: is " + number(*parameter.upper) + ", but the law allows " +
                     number(*row.upper) + " at the most");
  if (parameter.lower && parameter.upper && *parameter.lower > *parameter.upper)
    return bad_input(path + ".min: is " + number(*parameter.lower) + ", above max " +
                     number(*parameter.upper));
  for (const std::optional<double>& lower : {parameter.lower, row.lower})
    if (lower && parameter.value < *lower)
      return bad_input(path + ".value: is " + number(parameter.value) + ", below the bound " +
                       number(*lower));
  for (const std::optional<double>& upper : {parameter.upper, row.upper})
    if (upper && parameter.value > *upper)
      return bad_input(path + ".value: is " + number(parameter.value) + ", above the bound " +
                       number(*upper));
  if (parameter.std_error && *parameter.std_error < 0.0)
    return bad_input(path + ".std_error: must not be negative");
  if (parameter.interval_lo.has_value() != parameter.interval_hi.has_value())
    return bad_input(path + ".interval: must have both ends or none");
  if (parameter.interval_lo && *parameter.interval_lo > *parameter.interval_hi)
    return bad_input(path + ".interval: its lower end lies above its upper end");
  return {};
}

/// `expected` holds the catalogue's names and units; its rows come from `row_of`.
template <class RowOf>
Expected<void> check_parameters(const std::vector<Parameter>& parameters,
                                const std::vector<Parameter>& expected, RowOf row_of,
                                const std::string& path) {
  if (parameters.size() != expected.size())
    return bad_input(path + ": has " + std::to_string(parameters.size()) + " parameters, needs " +
                     std::to_string(expected.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = parameters[i];
    if (parameter.name != expected[i].name)
      return bad_input(path + "." + parameter.name + ": is not the parameter expected here, '" +
                       expected[i].name + "'");
    const std::string here = path + "." + parameter.name;
    if (parameter.unit != expected[i].unit)
      return bad_input(here + ".unit: is '" + parameter.unit + "', must be '" + expected[i].unit +
                       "'");
    if (auto checked = check_bounds(parameter, row_of(i), here); !checked) return checked;
  }
  return {};
}

Expected<void> check_knots(const Law& law, const std::string& path) {
  if (law.knots.empty()) return {};
  if (!may_have_knots(law))
    return bad_input(path + ".knots: only stiffness splines have knots, " + law.name + " has none");
  const std::size_t inner =
      static_cast<std::size_t>(spline_pieces(law, static_cast<int>(law.parameters.size()))) - 1;
  if (law.knots.size() != inner)
    return bad_input(path + ".knots: has " + std::to_string(law.knots.size()) + ", but " +
                     law.name + " with " + std::to_string(law.parameters.size()) +
                     " control points has " + std::to_string(inner) + " inside its range");
  double before = law.range_lo;
  for (const double knot : law.knots) {
    if (!(knot > before && knot < law.range_hi))
      return bad_input(path + ".knots: must rise, and lie inside the range");
    before = knot;
  }
  return {};
}

Expected<void> check_law(const Law& law, const StrainRow& strain, const std::string& path) {
  const LawRow* row = find_law(law.name);
  if (row == nullptr) return bad_input(path + ".name: there is no law '" + law.name + "'");
  if (row->strains != 0 && row->strains != strain.strains)
    return bad_input(path + ".name: " + law.name + " takes " + std::to_string(row->strains) +
                     " strain(s), but " + std::string(strain.name) + " gives " +
                     std::to_string(strain.strains));
  const int count = static_cast<int>(law.parameters.size());
  if (row->spline) {
    if (!std::isfinite(law.range_lo) || !std::isfinite(law.range_hi) || law.range_lo > law.range_hi)
      return bad_input(path + ".range: must be two finite numbers, the smaller one first");
    if (count < row->min_points || count > kMaxControlPoints)
      return bad_input(path + ".parameters: has " + std::to_string(count) +
                       " control points, must have " + std::to_string(row->min_points) + " to " +
                       std::to_string(kMaxControlPoints));
    const int side = static_cast<int>(std::lround(std::sqrt(count)));
    if (row->grid && side * side != count)
      return bad_input(path + ".parameters: has " + std::to_string(count) + " control points, " +
                       law.name + " needs a square number");
  } else if (law.range_lo != 0.0 || law.range_hi != 0.0) {
    return bad_input(path + ".range: only spline laws have a range, " + law.name + " has none");
  }
  if (auto checked = check_knots(law, path); !checked) return checked;
  return check_parameters(
      law.parameters, default_parameters(*row, count, strain.domain),
      [row, &strain](std::size_t i) {
        return in_domain(row->spline ? row->parameters.front() : row->parameters[i], strain.domain);
      },
      path + ".parameters");
}

Expected<void> check_support(const Support& support, const Model& model, const std::string& path) {
  if (support.name == "everywhere") {
    if (!support.field.empty() || support.sample != 0)
      return bad_input(path + ": 'everywhere' has no field and no sample");
    return {};
  }
  if (support.name != "rbf")
    return bad_input(path + ".name: there is no support '" + support.name +
                     "'; the supports are 'everywhere' and 'rbf'");
  for (const Field& field : model.fields) {
    if (field.id != support.field) continue;
    if (support.sample < 1 || support.sample > field.sample_count())
      return bad_input(path + ".sample: is " + std::to_string(support.sample) + ", but field '" +
                       field.id + "' has samples 1 to " + std::to_string(field.sample_count()));
    return {};
  }
  return bad_input(path + ".field: there is no field '" + support.field + "'");
}

Expected<void> check_field(const Field& field, const std::string& path) {
  if (!is_identifier(field.id)) return bad_input(path + ".id: " + kIdentifierRule);
  if (field.dimensions != 2 && field.dimensions != 3)
    return bad_input(path + ".positions_m: a position has 2 numbers on cloth, 3 in a solid");
  if (field.positions_m.empty() ||
      field.positions_m.size() % static_cast<std::size_t>(field.dimensions) != 0)
    return bad_input(path + ".positions_m: a field needs whole positions, and at least one");
  for (const double x : field.positions_m)
    if (!std::isfinite(x)) return bad_input(path + ".positions_m: must be finite numbers");
  if (!std::isfinite(field.width_m) || !(field.width_m > 0.0))
    return bad_input(path + ".width_m: must be a finite number above 0");
  return {};
}

Expected<void> check_term(const Term& term, const Model& model, const std::string& path) {
  if (!is_identifier(term.id)) return bad_input(path + ".id: " + kIdentifierRule);
  if (!term.effect.empty() && !is_identifier(term.effect))
    return bad_input(path + ".effect: " + kIdentifierRule);
  const StrainRow* strain = find_strain(term.strain.name);
  if (strain == nullptr)
    return bad_input(path + ".strain.name: there is no strain measure '" + term.strain.name + "'");
  if (!std::isfinite(term.strain.angle_rad))
    return bad_input(path + ".strain.angle_rad: must be a finite number");
  if (!strain->has_angle && term.strain.angle_rad != 0.0)
    return bad_input(path + ".strain.angle_rad: " + term.strain.name + " has no angle");
  if (!std::isfinite(term.strain.elevation_rad))
    return bad_input(path + ".strain.elevation_rad: must be a finite number");
  if (!(strain->has_angle && strain->domain == Domain::solid) && term.strain.elevation_rad != 0.0)
    return bad_input(path + ".strain.elevation_rad: " + term.strain.name + " has no elevation");
  if (auto checked = check_support(term.support, model, path + ".support"); !checked)
    return checked;
  return check_law(term.law, *strain, path + ".law");
}

/// The terms must be there and act on the same elements, else their energies have no sum.
Expected<void> check_limit(const EnergyLimit& limit, const Model& model, const std::string& path) {
  if (!is_identifier(limit.id)) return bad_input(path + ".id: " + kIdentifierRule);
  const Term* first = limit.terms.empty() ? &model.terms.front() : nullptr;
  const auto check_with = [&](const Term& term, const std::string& here) -> Expected<void> {
    if (first == nullptr) first = &term;
    const StrainRow* a = find_strain(first->strain.name);
    const StrainRow* b = find_strain(term.strain.name);
    const bool by_name = a->domain == Domain::edge || a->domain == Domain::hinge;
    if (a->domain != b->domain || (by_name && a != b))
      return bad_input(here + ": '" + first->id + "' and '" + term.id +
                       "' act on different elements, so that their energies have no sum");
    return {};
  };
  std::set<std::string> seen;
  for (std::size_t i = 0; i < limit.terms.size(); ++i) {
    const std::string here = at(path + ".terms", i);
    const Term* found = nullptr;
    for (const Term& term : model.terms)
      if (term.id == limit.terms[i]) found = &term;
    if (found == nullptr) return bad_input(here + ": there is no term '" + limit.terms[i] + "'");
    if (!seen.insert(limit.terms[i]).second)
      return bad_input(here + ": '" + limit.terms[i] + "' is named twice");
    if (auto checked = check_with(*found, here); !checked) return checked;
  }
  if (limit.terms.empty())
    for (const Term& term : model.terms)
      if (auto checked = check_with(term, path + ".terms"); !checked) return checked;
  if (!std::isfinite(limit.energy_max) || !(limit.energy_max > 0.0))
    return bad_input(path + ".energy_max.value: must be a finite number above 0");
  const std::string_view unit = energy_density_unit(find_strain(first->strain.name)->domain);
  if (limit.unit != unit)
    return bad_input(path + ".energy_max.unit: is '" + limit.unit + "', must be '" +
                     std::string(unit) + "'");
  return {};
}

Expected<void> check_correction(const SensorCorrection& correction, const std::string& path) {
  if (!is_identifier(correction.id)) return bad_input(path + ".id: " + kIdentifierRule);
  if (!correction.effect.empty() && !is_identifier(correction.effect))
    return bad_input(path + ".effect: " + kIdentifierRule);
  const CorrectionRow* of_curves = find_correction(correction.type, Seen::curves);
  const CorrectionRow* of_sheets = find_correction(correction.type, Seen::sheets);
  const CorrectionRow* row = of_curves;
  const bool may_be_of_sheets = of_sheets != nullptr && fits(correction, *of_sheets);
  if (row == nullptr || (may_be_of_sheets && !fits(correction, *row))) row = of_sheets;
  if (row == nullptr)
    return bad_input(path + ".type: there is no sensor correction '" + correction.type + "'");
  if (!correction.capture.empty() && !is_sha256(correction.capture) &&
      !(may_be_of_sheets && is_one_line(correction.capture)))
    return bad_input(path + ".capture: must be the SHA-256 of a capture");
  if (!correction.component.empty() && correction.component != "x" && correction.component != "y" &&
      correction.component != "xy" && !(may_be_of_sheets && is_identifier(correction.component)))
    return bad_input(path + ".component: must be 'x', 'y' or 'xy', not '" + correction.component +
                     "'");
  return check_parameters(
      correction.parameters, default_parameters(*row),
      [row](std::size_t i) -> const ParameterRow& { return row->parameters[i]; },
      path + ".parameters");
}

}  // namespace

Expected<void> validate(const Model& model) {
  if (!is_one_line(model.name))
    return bad_input("name: must be 1 to 200 bytes of text without line feeds");
  if (model.terms.empty()) return bad_input("terms: a model needs at least one term");

  std::set<std::string> ids;
  for (std::size_t i = 0; i < model.fields.size(); ++i) {
    const std::string path = at("fields", i);
    if (auto checked = check_field(model.fields[i], path); !checked) return checked;
    if (!ids.insert(model.fields[i].id).second)
      return bad_input(path + ".id: '" + model.fields[i].id + "' is used twice");
  }
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    const std::string path = at("terms", i);
    if (auto checked = check_term(model.terms[i], model, path); !checked) return checked;
    if (!ids.insert(model.terms[i].id).second)
      return bad_input(path + ".id: '" + model.terms[i].id + "' is used twice");
  }
  for (std::size_t i = 0; i < model.limits.size(); ++i) {
    const std::string path = at("limits", i);
    if (auto checked = check_limit(model.limits[i], model, path); !checked) return checked;
    if (!ids.insert(model.limits[i].id).second)
      return bad_input(path + ".id: '" + model.limits[i].id + "' is used twice");
  }
  for (std::size_t i = 0; i < model.corrections.size(); ++i) {
    const std::string path = at("corrections", i);
    if (auto checked = check_correction(model.corrections[i], path); !checked) return checked;
    if (!ids.insert(model.corrections[i].id).second)
      return bad_input(path + ".id: '" + model.corrections[i].id + "' is used twice");
  }
  for (std::size_t i = 0; i < model.strain_ranges.size(); ++i) {
    const StrainRange& range = model.strain_ranges[i];
    const std::string path = at("strain_ranges", i);
    bool known = false;
    for (const Term& term : model.terms) known = known || term.id == range.term;
    if (!known) return bad_input(path + ".term: there is no term '" + range.term + "'");
    if (!std::isfinite(range.lo) || !std::isfinite(range.hi) || range.lo > range.hi)
      return bad_input(path + ".lo: must be finite and not above hi");
  }
  if (model.lineage)
    for (std::size_t i = 0; i < model.lineage->captures.size(); ++i)
      if (!is_sha256(model.lineage->captures[i]))
        return bad_input(at("lineage.captures", i) + ": must be the SHA-256 of a capture");
  return {};
}

}  // namespace tenter::model
