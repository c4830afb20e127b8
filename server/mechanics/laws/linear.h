// SPDX-License-Identifier: GPL-3.0-or-later
// Constant stiffness, Psi = k/2 |eps|^2, on any number of strains, and the bilinear coupling Psi =
// c eps1 eps2 of the additive form of St. Venant-Kirchhoff (thesis 4.3), and the energy Psi = c
// eps, whose stress is constant, for strains that are energies already (invariants, squares).
//
// Linear stiffness (thesis 5.3.2): stress (k1 + k2 |eps|) eps, energy k1/2 eps^2 + k2/3 |eps|^3.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class LinearLaw final : public Law {
 public:
  explicit LinearLaw(int strains) : Law(strains, 1, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

class LinearStiffnessLaw final : public Law {
 public:
  explicit LinearStiffnessLaw(int strains) : Law(strains, 2, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class BilinearLaw final : public Law {
 public:
  BilinearLaw() : Law(2, 1, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

class ConstantStressLaw final : public Law {
 public:
  ConstantStressLaw() : Law(1, 1, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

}  // namespace tenter::mechanics
