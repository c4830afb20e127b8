// SPDX-License-Identifier: Apache-2.0
// The curve of a term, from its document alone: stress and tangent stiffness over a strain, for
// laws that are one curve and linear in their parameters,
//
//   stress(eps) = sum_j phi_j(eps) p_j,   stiffness(eps) = sum_j phi_j'(eps) p_j
//
// linear, constant_stress, hermite_stiffness, bspline_stiffness and convex_spline (thesis 3.3.2),
// hermite_energy and gaussian_energy (thesis 4.2). Laws that couple strains, have a memory or are
// not linear in a parameter have no such curve. server/mechanics computes the same numbers from its
// own tables for simulations; a test holds the two together.
//
//   if (const auto curve = TermCurve::of(term.law, Domain::membrane)) {
//     std::vector<double> phi;
//     curve->stress_basis(0.1, phi);
//   }
//
// Immutable; any thread.
#pragma once

#include <optional>
#include <vector>

#include "common/model/catalogue.h"
#include "common/model/model.h"

namespace tenter::model {

class TermCurve {
 public:
  /// None where the law is not such a curve. The law must be valid.
  static std::optional<TermCurve> of(const Law& law, Domain domain);

  int count() const { return points_; }
  /// phi_j and phi_j' at a strain, one for each parameter.
  void stress_basis(double strain, std::vector<double>& phi) const;
  void stiffness_basis(double strain, std::vector<double>& phi) const;

  /// With the values of the law's parameters.
  double stress(const Law& law, double strain) const;
  double stiffness(const Law& law, double strain) const;
  /// stress / strain; at zero its limit.
  double secant(const Law& law, double strain) const;

 private:
  enum class Form { linear, constant_stress, hermite, bspline, convex, hermite_energy, gaussian };
  struct Value {
    double value = 0.0, first = 0.0, second = 0.0;  ///< by the strain
  };
  /// Basis function j of the spline, with the continuation that its law has.
  Value basis(int j, double strain) const;
  double integral(int j, double strain) const;
  /// A strain in units of pieces: i + t in piece i, which its knots span; beyond the ends too.
  double coordinate(double strain) const;
  double piece_width(int piece) const;
  double knot(int i, int degree) const;
  double bspline(int j, int d, int degree, int span, double strain) const;
  double bspline_slope(int j, int degree, int span, double strain) const;

  Form form_ = Form::linear;
  int points_ = 1;
  int intervals_ = 1;
  double lo_ = 0.0;
  double width_ = 1.0;
  std::vector<double> knots_;  ///< ends of the pieces of a stiffness spline
};

}  // namespace tenter::model
