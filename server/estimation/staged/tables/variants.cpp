// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/tables/variants.h"

#include "common/model/presets.h"
#include "server/estimation/staged/splines/spline_refinement.h"

namespace tenter::estimation {

std::vector<Variant> all_variants() {
  std::vector<Variant> variants;
  for (const bool is_isotropic : {false, true})
    for (const bool is_nonlinear : {true, false})
      for (const ClothModel cloth :
           {ClothModel::soft_constraints, ClothModel::stvk, ClothModel::springs})
        variants.push_back({cloth, is_nonlinear, is_isotropic, {}});
  return variants;
}

std::string words_of(const Variant& variant) {
  return std::string(variant.is_nonlinear ? "Non-Linear " : "Linear ") +
         (variant.is_isotropic ? "Iso." : "Ortho.");
}

std::string words_of(ClothModel cloth) {
  switch (cloth) {
    case ClothModel::springs:
      return "Spring";
    case ClothModel::soft_constraints:
      return "Soft. Const.";
    case ClothModel::stvk:
      return "St.VK";
  }
  return "";
}

VariantModel variant_model(const Variant& variant) {
  std::string name = variant.cloth == ClothModel::springs            ? "cloth_springs"
                     : variant.cloth == ClothModel::soft_constraints ? "cloth_soft"
                                                                     : "cloth_stvk";
  if (variant.is_nonlinear) name += "_spline";
  VariantModel result;
  result.model = model::preset(name).value();
  if (!variant.curves.empty())
    for (model::Term& term : result.model.terms)
      if (is_spline(term.law)) term.law.name = variant.curves;
  const std::vector<std::string> shear = terms_of(result.model, Component::shear);
  if (shear.size() > 1) result.ties.push_back(shear);
  if (!variant.is_isotropic) return result;
  const auto both = [&](Component u, Component v) {
    std::vector<std::string> group = terms_of(result.model, u);
    for (std::string& id : terms_of(result.model, v)) group.push_back(std::move(id));
    result.ties.push_back(std::move(group));
  };
  both(Component::stretch_u, Component::stretch_v);
  both(Component::bend_u, Component::bend_v);
  return result;
}

Expected<AppendixRow> appendix_row(const Variant& variant,
                                   const std::vector<RoleSequence>& training,
                                   const std::vector<RoleSequence>& others, StagedOptions options) {
  VariantModel form = variant_model(variant);
  options.ties = std::move(form.ties);
  auto fit = staged_fit(std::move(form.model), training, options);
  if (!fit) return tl::unexpected(fit.error());
  AppendixRow row{variant, std::move(*fit), {}, {}};
  const auto measure = [&](const std::vector<RoleSequence>& sequences,
                           std::vector<ScenarioResidual>& into) -> Expected<void> {
    for (const RoleSequence& sequence : sequences) {
      auto residual = scenario_residual(row.fit.model, sequence);
      if (!residual) return tl::unexpected(residual.error());
      into.push_back(std::move(*residual));
    }
    return {};
  };
  if (auto ok = measure(training, row.training); !ok) return tl::unexpected(ok.error());
  if (auto ok = measure(others, row.others); !ok) return tl::unexpected(ok.error());
  return row;
}

}  // namespace tenter::estimation
