// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a sheet that were misread in a frame: a track that jumped to another dot and back.
//
// What a residual has beside the median of the frames about it, and beside each of the nearest
// points in its frame, in robust spreads of its kind: a misreading is far off all, with one sign. A
// misfit of the model goes on over the material or over the frames, if only to one side, and is
// not.
//
// Noise with long tails has more readings a little way out than far out, and misreadings have not:
// where that is so nothing is misread. Nor where more than a twentieth of all readings would be:
// such points scatter otherwise than their neighbours, frame after frame. Beside a point that is
// hidden only what is across the cameras' axis counts: what hides it draws them along that, and
// that is occlusion_bias.
//
//   const std::vector<Misread> misread = find_misread(sequences, rows, residuals);
//   set_aside(misread, sequences);                                           // and fit again
//
// Pure; linear in the readings.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

struct Misread {
  int sequence = 0;
  int frame = 0;
  int point = 0;
  double off_m = 0.0;  ///< of the coordinate that is farthest off, measured less what is near it
  double score = 0.0;  ///< the same in robust standard deviations
};

/// `residuals`: simulated less measured, in sigmas. In the order of sequences, frames, points.
std::vector<Misread> find_misread(const std::vector<estimation::Sequence>& sequences,
                                  const std::vector<estimation::Row>& rows,
                                  const Eigen::VectorXd& residuals);

/// They are seen no more, and count as misread, not as hidden.
void set_aside(const std::vector<Misread>& misread, std::vector<estimation::Sequence>& sequences);

}  // namespace tenter::diagnosis
