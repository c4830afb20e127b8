// SPDX-License-Identifier: GPL-3.0-or-later
// A first guess of a model's parameters without a single solve for equilibrium: forces are linear
// in control points at the measured positions, so what is missing to equilibrium there (the
// equation gap) is a linear least-squares problem with bounds.
//
//   G(q) = G_0 + D (q - q_0)       dPi/dx at the measured shape x, D = d2Pi/dx dp T
//   d(q) = -K^-1 G(q)              the way to equilibrium; K the stiffness at q_0
//   r(q) = [ (W (x + d) - points) / sigma_x ;  (pull(G + K d) - forces) / sigma_F ]
//   q    = argmin |r|^2,           lower <= q <= upper
//
// The noise of positions passes through the stiffness into forces, where it drowns the answer of a
// soft cloth: K^-1 takes it back (the gap is weighed by it), so nodes that nothing disturbs but
// noise say no more than their sigma. K is of the last guess, so a few rounds are taken, each with
// the shape settled by the last model (measured_shape.h). Exact where the data are without noise
// and all nodes are seen: then d = 0 at the truth, whatever K.
//
//   auto gap = equation_gap(model, ties, sequences, {});
//   if (gap) for (...) ties.free[k].value = gap->q[k];
//
// Where laws remember their path, it is walked along the measured shapes, all of them, and dG/dq is
// that of the whole path.
//
// Sequences say what is compared by what they hold: `shape` is where the positions come from, and
// `rows` which rows count (the thesis fits stretch and shear by forces alone). Pure; one thread.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/estimation/sequences/sequence.h"
#include "server/estimation/staged/parameter_ties.h"

namespace tenter::estimation {

enum class GapRows { all, positions, forces };

struct GapSequence {
  const Sequence* sequence = nullptr;  ///< with all that was measured
  GapRows rows = GapRows::all;
};

struct GapOptions {
  int most_frames = 8;   ///< of a sequence, evenly over it; all of a model that remembers
  int most_rounds = 8;   ///< with a new K
  double enough = 1e-3;  ///< relative change of every q after which no round follows
  double widest = 30.0;  ///< factor by which a round may change q, the last one aside
};

struct GapResult {
  Eigen::VectorXd q;  ///< of all free numbers; the fixed ones as they were
  std::vector<bool> is_at_bound;
  int frames = 0;           ///< that were used
  int frames_left_out = 0;  ///< without a shape or a stiffness
  int rounds = 0;
  int rank = 0;         ///< of the free numbers that are not fixed
  double misfit = 0.0;  ///< root mean square of r at q
};

/// bad_input as MeshModel::make and check(); refused where no frame could be used.
Expected<GapResult> equation_gap(const model::Model& model, const ParameterTies& ties,
                                 const std::vector<GapSequence>& sequences,
                                 const GapOptions& options);

}  // namespace tenter::estimation
