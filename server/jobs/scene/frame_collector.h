// SPDX-License-Identifier: GPL-3.0-or-later
// Gathers the frames of a scene for their file.
//
//   FrameCollector frames(run, model);
//   run.walk({.on_frame = [&](const SceneFrame& f) { ok = frames.add(f); }, ...});
//   write_frames(frames.set(), path);
#pragma once

#include <map>

#include "common/base/error.h"
#include "common/frames/frames.h"
#include "common/model/model.h"
#include "server/mechanics/scene/run.h"

namespace tenter::jobs {

/// What the frames of one job may take in memory; the file needs about as much again.
inline constexpr double kMostFrameBytes = 1.0e9;

class FrameCollector {
 public:
  FrameCollector(const mechanics::SceneRun& run, const model::Model& model);

  /// The first frame tells how much all of them will take: bad_input where it is too much.
  Expected<void> add(const mechanics::SceneFrame& frame);

  const frames::FrameSet& set() const { return set_; }

 private:
  void begin_strains(const std::vector<mechanics::TermStrains>& strains);
  void add_strains(const std::vector<mechanics::TermStrains>& strains);

  const model::Model model_;
  const int frames_asked_;
  std::map<mechanics::ElementKind, int> element_count_;
  frames::FrameSet set_;
};

}  // namespace tenter::jobs
