// SPDX-License-Identifier: GPL-3.0-or-later
// The measured skin of `skin-invivo-dic` (Elouneg et al. 2019, MIT) as a sequence: two pads on a
// patch of membrane, one pulled away; a field of displacements between them and the pad's force.
//
// Force and film are not on one clock: the force of a frame is read from the record at the pad's
// displacement that the film shows. Reference is the first frame, so the skin's own pre-stress is
// not in it; the edge of the patch is not known and is free or held, as asked.
#pragma once

#include <string>

#include "common/base/error.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::bench {

struct SkinData {
  estimation::Sequence sequence;
  Eigen::Vector2d between_m = Eigen::Vector2d::Zero();  ///< the corner of the strip between pads
  double gap_m = 0.0;                                   ///< its length along u
};

inline constexpr double kPointSigma_m = 3e-5;
inline constexpr double kForceSigma_N = 1e-3;

/// All filmed frames of `folder`, every `thinning`-th point. bad_input names the file.
Expected<SkinData> read_skin(const std::string& folder, bool edge_is_held, int thinning);

}  // namespace tenter::bench
