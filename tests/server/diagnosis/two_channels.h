// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks of one force of 10 N/m and one stretch of 1.1, sigma 0.5 and 0.001.
#pragma once

#include "server/estimation/prediction.h"

namespace tenter::diagnosis {

inline estimation::DataSet two_channels(int blocks, int frames_per_block) {
  estimation::DataSet set;
  estimation::Curves curves;
  estimation::ObservedChannel force;
  force.name = "stress_x";
  estimation::ObservedChannel stretch;
  stretch.name = "stretch_y";
  stretch.is_stress = false;
  stretch.component = 1;
  for (int b = 0; b < blocks; ++b) {
    curves.blocks.push_back(
        {0, capture::Branch::load, frames_per_block * b, frames_per_block * (b + 1)});
    for (int f = 0; f < frames_per_block; ++f) {
      curves.path.q.emplace_back(1.0, 1.0, 0.0);
      curves.block_of.push_back(b);
      force.measured.push_back(10.0);
      stretch.measured.push_back(1.1);
    }
  }
  const auto frames = static_cast<std::size_t>(blocks * frames_per_block);
  curves.channels = {force, stretch};
  set.left_out = {{std::vector<bool>(frames, false), std::vector<bool>(frames, false)}};
  set.curves.push_back(std::move(curves));
  set.sigma = {{0.5, 0.001}};
  return set;
}

}  // namespace tenter::diagnosis
