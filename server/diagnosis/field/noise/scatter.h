// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the residuals of a sequence scatters, whatever smooth misfit lies below?
//
// Three looks at it, each of which has all of white noise, and of a misfit as much as it does not
// take away:
//
//   differences   of order p: what p + 1 frames of a block have beside a polynomial of degree p - 1
//                 in the way of the clips. A smooth misfit falls with p, noise does not: p grows
//                 from 2 as long as the spread falls, and where it has stopped the rest is noise
//   repeats       frames with the clips where they were before, reached from the same side:
//                 (r_f - r_g) / sqrt 2. Nothing that depends on the way is left
//   returns       the same from either side: of what depends on the way, lag is left
//
// Spreads are robust (1.4826 median magnitude): misfits that jump are few. The smallest of the
// three counts, each with a standard error for what it may be too small by. It is a bound, noise is
// no larger, unless the differences stopped falling, or repeats show it, or another look agrees.
//
//   FrameContrasts frames(sequence);                                      // poses, ways, pairs
//   Looks looks;
//   for (const auto& channel : channels) looks.add(frames, channel);     // of as many as one likes
//   const Scatter scatter = looks.scatter();
//
// Pure; linear in the values, beside frames^2 pairs of poses.
#pragma once

#include <utility>
#include <vector>

#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

/// Values of several frames that count together: weights of unit norm.
struct Contrast {
  std::vector<int> frames;
  std::vector<double> weights;

  /// NaN where one is missing.
  double of(const std::vector<double>& values) const;
};

constexpr int kLowestOrder = 2, kHighestOrder = 6;

/// The contrasts of a sequence.
struct FrameContrasts {
  explicit FrameContrasts(const estimation::Sequence& sequence);

  std::vector<std::vector<Contrast>> differences;  ///< [order - kLowestOrder]
  std::vector<Contrast> repeats, returns;

  /// All of them: differences from the lowest order on, repeats, returns.
  std::vector<const std::vector<Contrast>*> looks() const;
};

struct Scatter {
  double spread = 0.0;    ///< 0: there are too few values
  int values = 0;         ///< that it was taken of
  bool is_bound = false;  ///< the noise is no larger; how much smaller is not known

  /// Relative standard error.
  double error() const;
};

/// Values of the contrasts, of any number of channels and sequences.
class Looks {
 public:
  Looks();
  /// `values`: one a frame; NaN where missing.
  void add(const FrameContrasts& frames, const std::vector<double>& values);
  /// A value of the look of this number, as FrameContrasts::looks has them.
  void add(std::size_t look, double value);
  Scatter scatter() const;

 private:
  std::vector<std::vector<double>> values_;
};

}  // namespace tenter::diagnosis
