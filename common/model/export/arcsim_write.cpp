// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/model/catalogue.h"
#include "common/model/export/arcsim.h"
#include "common/model/export/arcsim_samples.h"
#include "common/model/export/term_curve.h"

namespace tenter::model {
namespace {

using arcsim::Strains;

/// Psi = 1/2 (uu G11^2 + 2 uv G11 G22 + vv G22^2 + shear C12^2), N/m.
struct Membrane {
  double uu = 0.0, uv = 0.0, vv = 0.0, shear = 0.0;
};

/// Secant stiffness that one term adds at some strains. `term` must have passed refusal().
void add_term(const Term& term, const Strains& at, Membrane& k) {
  const std::string& strain = term.strain.name;
  const double first = term.law.parameters.front().value;
  if (term.law.name == "bilinear") {
    k.uv += first;
    return;
  }
  if (strain == "green_square") {  // c (G11^2 + G22^2 + 2 G12^2)
    k.uu += 2.0 * first;
    k.vv += 2.0 * first;
    k.shear += first;
    return;
  }
  const TermCurve curve = *TermCurve::of(term.law, Domain::membrane);
  const auto secant = [&](double eps) { return curve.secant(term.law, eps); };
  if (strain == "green_u") k.uu += secant(at.u);
  if (strain == "green_v") k.vv += secant(at.v);
  if (strain == "green_uv") k.shear += secant(at.uv);
  if (strain.starts_with("green_pair")) {
    k.uu += secant(at.u);
    k.vv += secant(at.v);
  }
  if (strain == "green_trace") {
    const double c = secant(at.u + at.v);
    k.uu += c;
    k.uv += c;
    k.vv += c;
  }
  if (strain == "green_deviator") {
    const double c = secant(at.u - at.v);
    k.uu += c;
    k.uv -= c;
    k.vv += c;
    k.shear += secant(at.uv);
  }
}

Membrane membrane_at(const Model& model, const Strains& at) {
  Membrane k;
  for (const Term& term : model.terms)
    if (find_strain(term.strain.name)->domain == Domain::membrane) add_term(term, at, k);
  return k;
}

/// Why a term cannot go over; empty where it can.
std::string refusal(const Term& term) {
  static constexpr std::string_view kCurves[] = {"green_u",       "green_v",       "green_uv",
                                                 "green_pair",    "green_pair_vu", "green_trace",
                                                 "green_deviator"};
  const StrainRow& strain = *find_strain(term.strain.name);
  const LawRow& law = *find_law(term.law.name);
  if (law.path_dependent) return "its law '" + term.law.name + "' has a memory";
  if (term.support.name != "everywhere") return "it acts around one sample of the material only";
  if (strain.domain == Domain::hinge) {
    if (TermCurve::of(term.law, Domain::hinge) && term.law.name != "constant_stress") return "";
    return "its law '" + term.law.name + "' is not a stiffness over one curvature";
  }
  if (term.law.name == "bilinear" && strain.name.starts_with("green_pair")) return "";
  if (term.law.name == "constant_stress" && strain.name == "green_square") return "";
  if (std::find(std::begin(kCurves), std::end(kCurves), strain.name) == std::end(kCurves))
    return "its strain '" + term.strain.name + "' is not made of Green strains along weft and warp";
  static constexpr std::string_view kStiffness[] = {"linear", "hermite_stiffness",
                                                    "bspline_stiffness", "convex_spline"};
  if (std::find(std::begin(kStiffness), std::end(kStiffness), law.name) != std::end(kStiffness))
    return "";
  return "its law '" + term.law.name + "' is not a stiffness over one strain";
}

Expected<void> check(const Model& model) {
  const std::string who = "ARCSim cannot take model '" + model.name + "': ";
  if (model.terms.empty()) return bad_input(who + "it has no terms");
  if (!model.limits.empty()) return bad_input(who + "it limits an energy");
  if (!model.corrections.empty()) return bad_input(who + "it corrects a sensor");
  for (const Term& term : model.terms)
    if (const std::string why = refusal(term); !why.empty())
      return bad_input(who + "in term '" + term.id + "' " + why);
  return {};
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100.0 * share);
  return text;
}

/// Largest departure of the straight line between rest and the last sample from the model, where
/// cloth is pulled at one angle, relative to the larger of the two ends.
double departure(const Model& model, int row, double Membrane::*member) {
  const Membrane rest = membrane_at(model, {});
  const Membrane end = membrane_at(model, arcsim::strains_of_row(row));
  const double scale = std::max(rest.*member, end.*member);
  if (!(scale > 0.0)) return 0.0;
  double worst = 0.0;
  constexpr int kSteps = 32;
  for (int i = 1; i < kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const double stretch = 1.0 + share * (arcsim::kLargestStretch - 1.0);
    const double angle = (row - 1) * std::acos(-1.0) / 8.0;
    const double model_says = membrane_at(model, arcsim::strains_of(stretch, angle)).*member;
    const double file_says = (1.0 - share) * (rest.*member) + share * (end.*member);
    worst = std::max(worst, std::abs(model_says - file_says) / scale);
  }
  return worst;
}

void add_losses(const Model& model, std::vector<std::string>& losses) {
  struct Way {
    const char* words;
    int row;
    double Membrane::*member;
  };
  for (const Way& way : {Way{"weft", 1, &Membrane::uu}, Way{"warp", 5, &Membrane::vv},
                         Way{"shear", 3, &Membrane::shear}})
    if (const double worst = departure(model, way.row, way.member); worst > 1e-9)
      losses.push_back(std::string("stiffness in ") + way.words +
                       " is straight up to a stretch of " + "7/6 and constant beyond: up to " +
                       percent(worst) + " away in between");
  for (const Term& term : model.terms) {
    if (find_strain(term.strain.name)->domain != Domain::hinge || term.law.name == "linear")
      continue;
    losses.push_back(
        "term '" + term.id +
        "': bending stiffness is kept at curvatures 0, 30, 60, 90 and 120 1/m, straight "
        "between them and constant beyond");
    if (term.law.range_lo < 0.0)
      losses.push_back("term '" + term.id + "': its curve for negative curvatures is lost");
  }
  for (const char* direction : {"bend_u", "bend_v", "bend_d"})
    if (std::none_of(model.terms.begin(), model.terms.end(),
                     [&](const Term& term) { return term.strain.name == direction; }))
      losses.push_back(std::string("the model has no ") + direction + ": zero bending stiffness");
}

Expected<nlohmann::ordered_json> stretching(const Model& model) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int row = 0; row < arcsim::kStretching; ++row) {
    const Membrane k = membrane_at(model, arcsim::strains_of_row(row));
    for (const double value : {k.uu, k.uv, k.vv, k.shear})
      if (!(value >= 0.0))
        return bad_input("ARCSim cannot take model '" + model.name +
                         "': it takes a negative stiffness as zero, and sample " +
                         std::to_string(row + 1) + " of stretching has one");
    rows.push_back({0.5 * k.uu, 0.5 * k.uv, 0.5 * k.vv, k.shear});
  }
  return rows;
}

Expected<nlohmann::ordered_json> bending(const Model& model) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const char* direction : {"bend_v", "bend_d", "bend_u"}) {
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (int i = 0; i < arcsim::kBending; ++i) {
      double k = 0.0;
      for (const Term& term : model.terms)
        if (term.strain.name == direction)
          k += TermCurve::of(term.law, Domain::hinge)
                   ->secant(term.law, i * arcsim::kCurvature_per_m);
      if (!(k >= 0.0))
        return bad_input("ARCSim cannot take model '" + model.name +
                         "': it takes a negative stiffness as zero, and " + direction + " has one");
      row.push_back(arcsim::kBendingFactor * k);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Expected<Exported> write_arcsim(const Model& model, double area_density_kg_m2) {
  if (!(area_density_kg_m2 > 0.0))
    return bad_input("an ARCSim material needs an area density above zero in kg/m^2");
  if (const auto checked = check(model); !checked) return tl::unexpected(checked.error());
  const auto stretch = stretching(model);
  if (!stretch) return tl::unexpected(stretch.error());
  const auto bend = bending(model);
  if (!bend) return tl::unexpected(bend.error());
  Exported result;
  result.text = nlohmann::ordered_json(
                    {{"density", area_density_kg_m2}, {"stretching", *stretch}, {"bending", *bend}})
                    .dump(2) +
                "\n";
  add_losses(model, result.losses);
  return result;
}

}  // namespace tenter::model
