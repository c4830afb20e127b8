// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of the law catalogue: a name and how to make the law. A new law adds its file and one
// row.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>

#include "common/model/catalogue.h"
#include "server/mechanics/law.h"
#include "server/mechanics/laws/dahl.h"
#include "server/mechanics/laws/exponential_fibre.h"
#include "server/mechanics/laws/gaussian_energy.h"
#include "server/mechanics/laws/hermite_energy.h"
#include "server/mechanics/laws/linear.h"
#include "server/mechanics/laws/linearised_dahl.h"
#include "server/mechanics/laws/memory.h"
#include "server/mechanics/laws/ogden.h"
#include "server/mechanics/laws/spline.h"
#include "server/mechanics/laws/stiffening.h"
#include "server/mechanics/laws/viscosity.h"

namespace tenter::mechanics {
namespace {

using LawPointer = std::shared_ptr<const Law>;

template <SplineLaw::Form kForm>
LawPointer make_spline(const model::Law& d, int strains) {
  const int points = static_cast<int>(d.parameters.size());
  if (points < 1 || points > kMaxLawParameters) return nullptr;
  if (points > 1 && !(d.range_hi > d.range_lo)) return nullptr;
  if (!d.knots.empty() && static_cast<int>(d.knots.size()) + 1 != model::spline_pieces(d, points))
    return nullptr;
  const std::vector<double> knots =
      points > 1 ? model::spline_knots(d) : std::vector{d.range_lo, d.range_hi};
  if (points > 1 && std::ranges::adjacent_find(knots, std::ranges::greater_equal{}) != knots.end())
    return nullptr;
  return std::make_shared<SplineLaw>(kForm, strains, points, knots, d.knots.empty());
}

LawPointer make_hermite_energy(const model::Law& d, int strains) {
  const int points = static_cast<int>(d.parameters.size());
  if (strains != 1 || points < 2 || points > kMaxLawParameters || !(d.range_hi > d.range_lo))
    return nullptr;
  return std::make_shared<HermiteEnergyLaw>(points, d.range_lo, d.range_hi);
}

template <int kStrains>
LawPointer make_gaussian_energy(const model::Law& d, int strains) {
  const int points = static_cast<int>(d.parameters.size());
  const int side =
      kStrains == 1 ? points : static_cast<int>(std::lround(std::sqrt(d.parameters.size())));
  if (strains != kStrains || side < 2 || points > kMaxLawParameters || !(d.range_hi > d.range_lo))
    return nullptr;
  return std::make_shared<GaussianEnergyLaw>(strains, side, d.range_lo, d.range_hi);
}

/// Laws of one strain only.
template <class L>
LawPointer make_single(const model::Law&, int strains) {
  return strains == 1 ? std::make_shared<L>() : nullptr;
}

/// Laws that act on each strain of the measure alike.
template <class L>
LawPointer make_each(const model::Law&, int strains) {
  return std::make_shared<L>(strains);
}

LawPointer make_bilinear(const model::Law&, int strains) {
  return strains == 2 ? std::make_shared<BilinearLaw>() : nullptr;
}

LawPointer make_cross_modal(const model::Law&, int strains) {
  return strains == 2 ? std::make_shared<CrossModalLaw>() : nullptr;
}

LawPointer make_coupled_set(const model::Law&, int strains) {
  return strains == 2 ? std::make_shared<CoupledPlasticSetLaw>() : nullptr;
}

struct Row {
  std::string_view name;
  LawPointer (*make)(const model::Law&, int strains);
};

constexpr Row kRows[] = {
    {"linear", make_each<LinearLaw>},
    {"linear_stiffness", make_each<LinearStiffnessLaw>},
    {"bilinear", make_bilinear},
    {"hermite_stiffness", make_spline<SplineLaw::Form::hermite_stiffness>},
    {"bspline_stiffness", make_spline<SplineLaw::Form::bspline_stiffness>},
    {"convex_spline", make_spline<SplineLaw::Form::convex>},
    {"constant_stress", make_single<ConstantStressLaw>},
    {"ogden", make_each<OgdenLaw>},
    {"hermite_energy", make_hermite_energy},
    {"gaussian_energy", make_gaussian_energy<1>},
    {"gaussian_energy_2", make_gaussian_energy<2>},
    {"exponential_fibre", make_single<ExponentialFibreLaw>},
    {"dahl", make_each<DahlLaw>},
    {"dahl_linearised", make_single<LinearisedDahlLaw>},
    {"maxwell", make_each<MaxwellLaw>},
    {"kelvin_voigt", make_each<KelvinVoigtLaw>},
    {"plastic_set", make_single<PlasticSetLaw>},
    {"plastic_set_coupled", make_coupled_set},
    {"softening", make_single<SofteningLaw>},
    {"cross_modal", make_cross_modal},
    {"strain_limit", make_each<StrainLimitLaw>},
};

}  // namespace

Expected<std::shared_ptr<const Law>> make_law(const model::Law& description, int strain_count) {
  for (const Row& row : kRows) {
    if (row.name != description.name) continue;
    LawPointer law = row.make(description, strain_count);
    if (!law)
      return bad_input("the law \"" + description.name + "\" does not fit a measure of " +
                       std::to_string(strain_count) + " strains with the parameters given");
    if (law->parameter_count() != static_cast<int>(description.parameters.size()))
      return bad_input("the law \"" + description.name + "\" takes " +
                       std::to_string(law->parameter_count()) + " parameters, " +
                       std::to_string(description.parameters.size()) + " are given");
    return law;
  }
  return bad_input("no law is called \"" + description.name + "\"");
}

}  // namespace tenter::mechanics
