// SPDX-License-Identifier: GPL-3.0-or-later
// Which pull would tell a cause from others that the captures at hand cannot? Of a family of pulls
// (loops at two rates, holds, nested loops, returns, offsets, repeats, a wider range), in mountings
// that the captures show, the one within the rig's limits where the models of the causes are
// expected to be farthest apart.
//
//   if (auto best = design_next(rivals, bench, {}))
//     words_of(best->plan), best->separation.of_noise()
//
// Evidence counts by branches, not by samples: S over its readings, times the branches. What can be
// pulled, and what models say of it, is the bench's: curves (curve_bench.h), sheets (clip_bench.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/next/separation.h"

namespace tenter::diagnosis {

/// Whether what shall be told apart is a question of rates, which only a second rate or a hold
/// answers, however far apart two fitted models may be otherwise.
enum class Question { any, of_rate };

/// A capture in which a specimen was held and pulled in one way, the farthest of those.
struct Mounting {
  std::string mounted_as;  ///< its title
  int capture = 0;         ///< of the data
  int component = 0;       ///< as in Experiment
  double reach = 0.0;      ///< strain
};

struct Bench {
  std::vector<Mounting> mountings;
  double fastest_per_s = 0.0;  ///< of what was captured; zero: not known
  double strongest = 0.0;      ///< force that is allowed, as in Separation
  /// What rival number k says of a plan; nothing where it cannot do it.
  std::function<std::optional<Foretold>(const Experiment&, const Mounting&, std::size_t k)>
      foretell;
};

/// What splits the first rival from all others. Nothing where no pull within the limits would bring
/// it half a sigma (rms) from each.
std::optional<Design> design_next(const std::vector<const Reference*>& rivals, const Bench& bench,
                                  const RigLimits& limits, Question question = Question::any);

/// Puts a design in the place of a protocol's words.
void describe(const Design& design, NextProtocol& protocol);

}  // namespace tenter::diagnosis
