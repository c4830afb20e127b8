// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/base/json_node.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/export/arcsim.h"
#include "common/model/export/arcsim_samples.h"
#include "common/model/export/term_curve.h"

namespace tenter::model {
namespace {

struct Material {
  double density = 0.0;
  std::array<std::array<double, 4>, arcsim::kStretching> stretching{};
  std::array<std::array<double, arcsim::kBending>, 3> bending{};
};

/// Other keys (damping, comments of the simulator's own files) are left alone.
Material read_material(const JsonNode& root) {
  root.expect_object();
  Material material;
  material.density = root["density"].number();
  if (!(material.density > 0.0)) root["density"].refuse("must be above zero");
  const auto stretching = root["stretching"].list();
  if (stretching.size() != material.stretching.size())
    root["stretching"].refuse("must hold 6 samples");
  for (std::size_t i = 0; i < stretching.size(); ++i)
    material.stretching[i] = stretching[i].numbers<4>();
  const auto bending = root["bending"].list();
  if (bending.size() != material.bending.size()) root["bending"].refuse("must hold 3 directions");
  for (std::size_t i = 0; i < bending.size(); ++i)
    material.bending[i] = bending[i].numbers<arcsim::kBending>();
  return material;
}

/// The simulator takes negative numbers as zero.
int clamp_negative(Material& material) {
  int count = 0;
  const auto clamp = [&](double& value) {
    if (value >= 0.0) return;
    value = 0.0;
    ++count;
  };
  for (auto& row : material.stretching)
    for (double& value : row) clamp(value);
  for (auto& row : material.bending)
    for (double& value : row) clamp(value);
  return count;
}

/// A stiffness curve through even points, or a constant where they are all equal.
Term curve_term(const std::string& id, const std::string& strain, Domain domain, double hi,
                const std::vector<double>& values) {
  Term term;
  term.id = id;
  term.strain.name = strain;
  const bool is_constant =
      std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
  term.law.name = is_constant ? "linear" : "hermite_stiffness";
  if (!is_constant) term.law.range_hi = hi;
  const LawRow& row = *find_law(term.law.name);
  term.law.parameters = default_parameters(row, static_cast<int>(values.size()), domain);
  for (std::size_t i = 0; i < term.law.parameters.size(); ++i)
    term.law.parameters[i].value = values[i];
  return term;
}

void add_membrane(const Material& m, Model& model) {
  const auto& rest = m.stretching[0];
  const auto straight = [&](const char* id, const char* strain, int row, int entry, double factor) {
    const auto e = static_cast<std::size_t>(entry);
    model.terms.push_back(
        curve_term(id, strain, Domain::membrane, arcsim::kGreen,
                   {factor * rest[e], factor * m.stretching[static_cast<std::size_t>(row)][e]}));
  };
  straight("weft", "green_u", 1, 0, 2.0);
  straight("warp", "green_v", 5, 2, 2.0);
  double coupling = 0.0;
  for (const auto& row : m.stretching) coupling += 2.0 * row[1] / arcsim::kStretching;
  if (std::all_of(m.stretching.begin(), m.stretching.end(),
                  [&](const auto& row) { return row[1] == rest[1]; }))
    coupling = 2.0 * rest[1];  // without the rounding of a mean
  if (coupling > 0.0) {
    Term term;
    term.id = "coupling";
    term.strain.name = "green_pair";
    term.law.name = "bilinear";
    term.law.parameters = default_parameters(*find_law("bilinear"));
    term.law.parameters[0].value = coupling;
    model.terms.push_back(std::move(term));
  }
  straight("shear", "green_uv", 3, 3, 1.0);
}

void add_bending(const Material& m, Model& model) {
  struct Row {
    const char* id;
    const char* strain;
    int index;
  };
  for (const Row& row : {Row{"bend_weft", "bend_u", 2}, Row{"bend_warp", "bend_v", 0},
                         Row{"bend_diagonal", "bend_d", 1}}) {
    std::vector<double> values;
    for (const double v : m.bending[static_cast<std::size_t>(row.index)])
      values.push_back(v / arcsim::kBendingFactor);
    model.terms.push_back(curve_term(row.id, row.strain, Domain::hinge,
                                     (arcsim::kBending - 1) * arcsim::kCurvature_per_m, values));
  }
}

/// How far the file's samples are from the model's, each entry relative to its largest.
std::vector<std::string> departures(const Material& m, const Model& model) {
  static constexpr const char* kEntries[] = {"c11", "c12", "c22", "c33"};
  std::vector<std::string> losses;
  std::array<double, 4> worst{}, scale{};
  for (int row = 0; row < arcsim::kStretching; ++row) {
    const arcsim::Strains at = arcsim::strains_of_row(row);
    const double strains[] = {at.u, 0.0, at.v, at.uv};
    static constexpr const char* kTerms[] = {"weft", "coupling", "warp", "shear"};
    for (std::size_t e = 0; e < 4; ++e) {
      double says = 0.0;
      for (const Term& term : model.terms)
        if (term.id == kTerms[e])
          says = e == 1 ? term.law.parameters[0].value
                        : TermCurve::of(term.law, Domain::membrane)->secant(term.law, strains[e]);
      if (e != 3) says *= 0.5;
      const double file = m.stretching[static_cast<std::size_t>(row)][e];
      worst[e] = std::max(worst[e], std::abs(says - file));
      scale[e] = std::max(scale[e], file);
    }
  }
  for (std::size_t e = 0; e < 4; ++e)
    if (worst[e] > 1e-9 * scale[e]) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "%s depends on more than its own strain: the model is up to %.3g %% of its "
                    "largest value away from a sample",
                    kEntries[e], 100.0 * worst[e] / scale[e]);
      losses.emplace_back(text);
    }
  return losses;
}

}  // namespace

Expected<ImportedModel> read_arcsim(std::string_view text, std::string_view source_name,
                                    const std::string& name) {
  auto material = read_document(text, source_name, kMaxDocumentBytes, read_material);
  if (!material) return tl::unexpected(material.error());
  ImportedModel result;
  result.area_density_kg_m2 = material->density;
  if (const int count = clamp_negative(*material); count > 0)
    result.losses.push_back(std::to_string(count) +
                            " negative stiffnesses are taken as zero, as the simulator does");
  char density[64];
  std::snprintf(density, sizeof density, "%.6g", material->density);
  result.model.name = name;
  result.model.description = std::string("Read from an ARCSim material of area density ") +
                             density + " kg/m^2: stiffness curves of Green strains, and bending.";
  add_membrane(*material, result.model);
  add_bending(*material, result.model);
  if (auto valid = validate(result.model); !valid)
    return bad_input(std::string(source_name) + ": " + valid.error().message);
  for (std::string& loss : departures(*material, result.model))
    result.losses.push_back(std::move(loss));
  return result;
}

}  // namespace tenter::model
