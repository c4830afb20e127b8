// SPDX-License-Identifier: GPL-3.0-or-later
// A = L L' for a sparse symmetric positive definite matrix, many times with the same pattern: the
// inner solve of equilibrium, of sensitivities and of implicit steps.
//
//   const std::unique_ptr<SparseFactor> factor = make_factor();
//   factor->analyze(pattern);                                    // once per pattern
//   if (factor->factorize(values) != FactorStatus::ok) ...       // shift the matrix, try again
//   factor->solve(right_sides, solutions, count);                // as often as wanted
//
// One thread per factor at a time; several factors may work in several threads. The same calls give
// the same bytes, run after run and from any thread. The factor keeps its scratch: after the first
// factorize, and the first solve with a given count, nothing is allocated (CHOLMOD allocates inside
// its own factorisation, and when the count changes).
#pragma once

#include <cstddef>
#include <memory>

#include "server/mechanics/sparse/symmetric_pattern.h"

namespace tenter::mechanics {

/// How a factorisation ended.
enum class FactorStatus {
  ok,                     ///< solve may be called
  not_positive_definite,  ///< a pivot fell to rounding of its diagonal entry, or below zero
  not_finite,             ///< the values hold NaN or infinity
  out_of_memory           ///< the factor does not fit
};

/// A pivot of at most this part of the diagonal entry that it came from is rounding, not stiffness.
constexpr double kTinyPivot = 1e-15;

/// What the pattern of the last analyze costs.
struct FactorCost {
  double flops = 0.0;           ///< additions and multiplications of one factorize
  double factor_entries = 0.0;  ///< of L, with the zeros that are stored
  std::size_t bytes = 0;        ///< held by the factor: L, symbolic part, scratch
};

class SparseFactor {
 public:
  virtual ~SparseFactor() = default;

  /// Ordering and symbolic factorisation; forgets an earlier pattern and its numbers. Costs about
  /// as much as one to ten factorisations.
  virtual void analyze(const SymmetricPattern& pattern) = 0;

  /// Numbers of L. `values` has one entry per entry of the pattern. After any status but ok there
  /// is no factor: solve needs a factorize that succeeds first.
  [[nodiscard]] virtual FactorStatus factorize(const double* values) = 0;

  /// A X = B for `count` right-hand sides, columns of length pattern.size one after the other;
  /// right_sides == solutions is allowed. Each column comes out as it would alone, to rounding.
  /// Requires a factorize that ended ok.
  virtual void solve(const double* right_sides, double* solutions, int count) = 0;

  virtual FactorCost cost() const = 0;
};

/// CHOLMOD's supernodal factorisation: the check and the fallback. It and the BLAS below it are
/// held to one thread: from the first factor made here the BLAS of the whole process has one
/// thread.
std::unique_ptr<SparseFactor> make_cholmod_factor();

/// Instructions of the factorisation below. Each gives the same bytes run after run; between two of
/// them results differ by rounding. `best` is what the processor can, and stands in for what it
/// can't.
enum class InstructionSet { best, avx512, avx2, portable };

/// Our own supernodal factorisation with kernels for small panels. No BLAS, no threads, and of
/// CHOLMOD only its orderings, which are LGPL.
std::unique_ptr<SparseFactor> make_supernodal_factor(InstructionSet wanted = InstructionSet::best);

/// What to use: ours where the processor has AVX2 or better, as measured; else CHOLMOD's.
std::unique_ptr<SparseFactor> make_factor();

}  // namespace tenter::mechanics
