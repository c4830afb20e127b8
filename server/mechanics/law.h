// SPDX-License-Identifier: GPL-3.0-or-later
// Laws: what a term answers to its strain.
//
// A law maps the strain of this instant, and for path-dependent laws its state at the start of the
// step and the step's duration, to energy density (N/m), stress (N/m), tangent, the state at the
// end, and the derivatives of all of these by strain, parameters and starting state. Between two
// frames the strain is taken to change linearly in time.
//
//   energy     path-independent laws: stored energy; path-dependent laws: incremental potential of
//   the step, whose
//              derivative by the strain is the stress (architecture.md), up to a constant
//   state      a few scalars; what each means, and what survives between runs, is said by
//   state_kind
//
// A law is immutable and stateless: callable from any thread. Nothing here allocates.
#pragma once

#include <memory>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::mechanics {

constexpr int kMaxLawParameters = 36;  ///< a grid of 6 x 6 energies
constexpr int kMaxLawState = 2 * kMaxStrains;

struct LawInput {
  const double* strain = nullptr;      ///< as many as the law takes
  const double* parameters = nullptr;  ///< in the catalogue's order
  const double* state = nullptr;       ///< at the start of the step
  double duration_s = 0.0;             ///< of the step; 0 on the first frame of a run
  bool wants_energy = true;  ///< laws whose energy is dear leave it at zero where it is not wanted
};

struct LawOutput {
  double energy = 0.0;
  double stress[kMaxStrains];
  double tangent[kMaxStrains][kMaxStrains];
  double stress_by_parameter[kMaxStrains][kMaxLawParameters];
  double stress_by_state[kMaxStrains][kMaxLawState];
  double state[kMaxLawState];
  double state_by_strain[kMaxLawState][kMaxStrains];
  double state_by_parameter[kMaxLawState][kMaxLawParameters];
  double state_by_state[kMaxLawState][kMaxLawState];
};

/// Many strains of one law at once, as structure of arrays: entry e of every array belongs to
/// element e. All that is asked for is overwritten.
struct LawBatch {
  int count = 0;
  const double* strain[kMaxStrains] = {};
  /// Where the step starts, one array a state variable. Null at [0]: never strained before.
  const double* state[kMaxLawState] = {};
  double duration_s = 0.0;
  double* end_state[kMaxLawState] = {};  ///< null at [0] where not wanted
  double* energy = nullptr;              ///< null where not wanted
  double* stress[kMaxStrains] = {};
  /// The upper triangle, [i][j] with i <= j; null at [0][0]: no tangent is wanted.
  double* tangent[kMaxStrains][kMaxStrains] = {};
};

/// What happens to a state variable when a run begins on a specimen that was pulled before.
enum class StateKind {
  transient,    ///< forgotten when the specimen was unloaded out of sight: back to zero
  last_strain,  ///< the strain where the step starts: rest (zero) then
  memory        ///< survives until a new specimen
};

class Law {
 public:
  virtual ~Law() = default;
  int strain_count() const { return strain_count_; }
  int parameter_count() const { return parameter_count_; }
  int state_count() const { return state_count_; }
  virtual StateKind state_kind(int) const { return StateKind::memory; }
  /// Answers to nothing but the rate (strain - state)/duration.
  virtual bool is_rate() const { return false; }
  /// The tangent jumps where a strain is what it was at the start of the step, which is a state
  /// variable for each.
  virtual bool turns_round() const { return false; }
  /// Zeroes the part of `out` that belongs to this law's strains, parameters and states.
  void clear(LawOutput& out) const;
  /// `out` must have been cleared or zeroed; the law writes what differs from zero.
  virtual void evaluate(const LawInput& in, LawOutput& out) const = 0;
  /// The same answers to rounding, for many strains with the same parameters. By default a loop
  /// over evaluate(); laws on the path of mesh assembly have their own.
  virtual void evaluate_batch(const double* parameters, const LawBatch& batch) const;
  /// d(stress)/d(parameter) of many strains into `batch.stress`; nothing else of the batch is
  /// written.
  virtual void stress_by_parameter_batch(const double* parameters, int parameter,
                                         const LawBatch& batch) const;

 protected:
  Law(int strains, int parameters, int states)
      : strain_count_(strains), parameter_count_(parameters), state_count_(states) {}

 private:
  int strain_count_;
  int parameter_count_;
  int state_count_;
};

/// `strain_count` is that of the term's measure; bad_input where the law does not take so many, is
/// unknown, or has the wrong parameters.
Expected<std::shared_ptr<const Law>> make_law(const model::Law& description, int strain_count);

}  // namespace tenter::mechanics
