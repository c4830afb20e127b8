// SPDX-License-Identifier: GPL-3.0-or-later
// A model's energy density at one deformation gradient, with its derivatives by z, summed up over
// its terms as an assembly does: what textbook forms are compared with.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "common/model/catalogue.h"
#include "common/model/model.h"
#include "server/mechanics/law.h"
#include "server/mechanics/solid_strain.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::testing {

template <int N>
struct PointEnergy {
  double energy = 0.0;
  Eigen::Matrix<double, N, 1> by_z = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> by_zz = Eigen::Matrix<double, N, N>::Zero();
};

/// N is 3 on membranes (C_uu, C_vv, C_uv), 6 in solids; parameters are the values of the model.
template <int N>
PointEnergy<N> energy_at(const model::Model& model, const Eigen::Matrix<double, N, 1>& z) {
  PointEnergy<N> sum;
  for (const model::Term& term : model.terms) {
    mechanics::LawOutput law{};
    std::vector<double> parameters;
    for (const model::Parameter& p : term.law.parameters) parameters.push_back(p.value);
    const auto add = [&](const auto& measure, auto& strain, const auto* by_z, const auto* by_zz) {
      const auto made = mechanics::make_law(term.law, measure.count());
      ASSERT_TRUE(made) << term.id;
      (*made)->evaluate({strain.value, parameters.data(), nullptr, 0.0}, law);
      sum.energy += law.energy;
      for (int i = 0; i < measure.count(); ++i) {
        sum.by_z += law.stress[i] * by_z[i];
        sum.by_zz += law.stress[i] * by_zz[i];
        for (int j = 0; j < measure.count(); ++j)
          sum.by_zz += law.tangent[i][j] * by_z[i] * by_z[j].transpose();
      }
      mechanics::add_near_pairs(strain.near, strain.near_count, strain.value, law.stress,
                                law.tangent, sum.by_zz);
    };
    if constexpr (N == 6) {
      const auto measure = mechanics::SolidStrain::make(term.strain);
      EXPECT_TRUE(measure) << term.id;
      mechanics::SolidStrainValue strain;
      measure->evaluate(z, strain);
      add(*measure, strain, strain.by_z, strain.by_zz);
    } else {
      const auto measure = mechanics::StrainMeasure::make(term.strain);
      EXPECT_TRUE(measure) << term.id;
      mechanics::StrainValue strain;
      measure->evaluate(z, strain);
      add(*measure, strain, strain.by_c, strain.by_cc);
    }
  }
  return sum;
}

/// First Piola-Kirchhoff stress dPsi/dF = 2 F dPsi/dC; entries of C beside the diagonal count
/// twice.
inline Eigen::Matrix3d stress_of(const Eigen::Matrix3d& f, const PointEnergy<6>& e) {
  Eigen::Matrix3d by_c;
  by_c << e.by_z[0], 0.5 * e.by_z[5], 0.5 * e.by_z[4],  //
      0.5 * e.by_z[5], e.by_z[1], 0.5 * e.by_z[3],      //
      0.5 * e.by_z[4], 0.5 * e.by_z[3], e.by_z[2];
  return 2.0 * f * by_c;
}
inline Eigen::Matrix2d stress_of(const Eigen::Matrix2d& f, const PointEnergy<3>& e) {
  Eigen::Matrix2d by_c;
  by_c << e.by_z[0], 0.5 * e.by_z[2], 0.5 * e.by_z[2], e.by_z[1];
  return 2.0 * f * by_c;
}

/// A model of these terms, without units and bounds: (measure, law, values).
struct TermOf {
  const char* strain;
  const char* law;
  std::vector<double> values;
};
inline model::Model model_of(const std::vector<TermOf>& terms) {
  model::Model model;
  for (const TermOf& t : terms) {
    model::Term term;
    term.id = "term_" + std::to_string(model.terms.size());
    term.strain.name = t.strain;
    term.law.name = t.law;
    term.law.parameters = model::default_parameters(*model::find_law(t.law));
    EXPECT_EQ(term.law.parameters.size(), t.values.size());
    for (std::size_t i = 0; i < t.values.size(); ++i) term.law.parameters[i].value = t.values[i];
    model.terms.push_back(std::move(term));
  }
  return model;
}

}  // namespace tenter::testing
