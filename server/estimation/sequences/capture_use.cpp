// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/from_capture.h"

namespace tenter::estimation {

std::string in_words(const CaptureUse& use) {
  std::string text = std::to_string(use.points) + " of " + std::to_string(use.vertices) +
                     " vertices compared in " + std::to_string(use.frames) + " frames, " +
                     std::to_string(use.readings) + " coordinates" +
                     (use.has_graded_grid ? ", on a graded grid" : "");
  std::string left_out;
  const auto add = [&left_out](int count, const char* why) {
    if (count > 0) left_out += (left_out.empty() ? "" : ", ") + std::to_string(count) + " " + why;
  };
  add(use.in_clips, "vertices in clips");
  add(use.outside, "vertices outside of the mesh");
  add(use.never_seen, "vertices never seen");
  add(use.thinned, "vertices thinned out");
  add(use.missing, "coordinates not seen");
  add(use.held, "coordinates on a support");
  add(use.missing_forces, "forces not measured");
  add(use.thinned_frames, "frames thinned out");
  add(static_cast<int>(use.slack_frames.size()), "slack frames");
  add(static_cast<int>(use.dropped_frames.size()), "frames without a free clip's load");
  return text + (left_out.empty() ? "" : "; left out: " + left_out);
}

}  // namespace tenter::estimation
