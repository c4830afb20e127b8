// SPDX-License-Identifier: Apache-2.0
#include "common/model/export/curves.h"

#include <algorithm>

#include "common/model/catalogue.h"
#include "common/model/export/term_curve.h"

namespace tenter::model {
namespace {

/// The unit of energy / strain^n in a domain.
std::string unit_per_strain(Domain domain, int n) {
  const ParameterRow row = {"", "N/m", std::nullopt, std::nullopt, 0.0, false, n};
  return std::string(in_domain(row, domain).unit);
}

std::optional<std::pair<double, double>> reached_by(const Model& model, const Term& term) {
  for (const StrainRange& range : model.strain_ranges)
    if (range.term == term.id) return std::pair{range.lo, range.hi};
  return std::nullopt;
}

bool has_band(const Law& law) {
  return std::all_of(law.parameters.begin(), law.parameters.end(), [](const Parameter& p) {
    return p.fixed || (p.interval_lo && p.interval_hi);
  });
}

void add_sample(const Law& law, const std::vector<double>& phi, bool with_band, Band& band) {
  double value = 0.0, lo = 0.0, hi = 0.0;
  for (std::size_t j = 0; j < phi.size(); ++j) {
    const Parameter& p = law.parameters[j];
    value += phi[j] * p.value;
    const double a = phi[j] * (p.fixed ? p.value : p.interval_lo.value_or(p.value));
    const double b = phi[j] * (p.fixed ? p.value : p.interval_hi.value_or(p.value));
    lo += std::min(a, b);
    hi += std::max(a, b);
  }
  band.value.push_back(value);
  if (!with_band) return;
  band.lo.push_back(lo);
  band.hi.push_back(hi);
}

}  // namespace

CurveSet curves_of(const Model& model, int samples) {
  CurveSet set;
  std::vector<double> phi;
  for (const Term& term : model.terms) {
    const StrainRow* strain = find_strain(term.strain.name);
    const LawRow* law = find_law(term.law.name);
    const auto curve = TermCurve::of(term.law, strain->domain);
    if (!curve) {
      set.left_out.push_back("term '" + term.id + "' is left out: the law '" + term.law.name +
                             "' is not a curve of one strain that is linear in its parameters");
      continue;
    }
    CurveTable table;
    table.term = term.id;
    table.strain_measure = term.strain.name;
    table.strain_unit = strain->domain == Domain::hinge ? "1/m" : "1";
    table.stress_unit = unit_per_strain(strain->domain, 1);
    table.stiffness_unit = unit_per_strain(strain->domain, 2);
    table.reached = reached_by(model, term);
    auto [lo, hi] = spline_range(term.law, strain->domain);
    if (table.reached) {
      const bool has_points = law->spline && term.law.range_lo != term.law.range_hi;
      lo = has_points ? std::min(lo, table.reached->first) : table.reached->first;
      hi = has_points ? std::max(hi, table.reached->second) : table.reached->second;
    }
    const bool with_band = has_band(term.law);
    for (int i = 0; i < samples; ++i) {
      const double eps = i + 1 == samples ? hi : lo + (hi - lo) * i / (samples - 1);
      table.strain.push_back(eps);
      curve->stress_basis(eps, phi);
      add_sample(term.law, phi, with_band, table.stress);
      curve->stiffness_basis(eps, phi);
      add_sample(term.law, phi, with_band, table.stiffness);
    }
    set.curves.push_back(std::move(table));
  }
  return set;
}

}  // namespace tenter::model
