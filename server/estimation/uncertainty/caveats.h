// SPDX-License-Identifier: GPL-3.0-or-later
// What a report on a fit must not keep to itself: everything that makes one of its numbers mean
// less than it seems to, as a list of a kind, a subject and a sentence each. An empty list is a
// statement too: nothing was frozen, dropped, at a bound, or beyond the data.
//
//   const std::vector<Caveat> list = caveats(model, found, options, profiles, dropped);
//
// Pure; any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/estimation/uncertainty/profile.h"

namespace tenter::estimation {

enum class CaveatKind {
  not_converged,
  frozen,          ///< fixed by the document: its value is an assumption
  zero_gradient,   ///< nothing in the data moves with it
  at_bound,        ///< its value is the bound's
  flat,            ///< the data do not determine it
  one_sided,       ///< only one end of its interval exists
  multimodal,      ///< another value fits as well
  correlated,      ///< only a combination with another is determined
  beyond_data,     ///< a spline has control points where no strain was measured
  dropped_frames,  ///< frames without an equilibrium, or left out
  rows_left_out,   ///< rows of weight zero
  wrong_form,      ///< residuals are larger than the noise: intervals are widened
  gains_work       ///< a friction gives back more work than it took, somewhere
};
/// "not_converged" and the like.
std::string_view words_of(CaveatKind kind);

struct Caveat {
  CaveatKind kind = CaveatKind::not_converged;
  std::string subject;   ///< "term.parameter", a term, or a sequence
  std::string sentence;  ///< whole, with the numbers
};

/// Frames that took no part, by whom they were measured.
struct DroppedFrames {
  std::string name;  ///< of the sequence or capture
  std::vector<int> frames;
  std::string why;
};

struct CaveatOptions {
  double correlation = 0.95;  ///< magnitude that is told
  double wrong_form = 1.5;    ///< chi2 per row that is told
};

/// In the order of CaveatKind, then of the parameters. `profiles` may be empty.
std::vector<Caveat> caveats(const model::Model& model, const FitResult& found,
                            const FitOptions& options, const std::vector<Profile>& profiles,
                            const std::vector<DroppedFrames>& dropped,
                            const CaveatOptions& caveat_options = {});

}  // namespace tenter::estimation
