// SPDX-License-Identifier: Apache-2.0
#include "common/capture/run_selection.h"

#include <algorithm>

namespace tenter::capture {

namespace {

/// Keeps the groups of `per_frame` values that belong to kept frames; none stay none.
template <class T>
void keep(const std::vector<std::size_t>& frames, std::size_t per_frame, std::vector<T>& values) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < frames.size(); ++i)
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(frames[i] * per_frame), per_frame,
                values.begin() + static_cast<std::ptrdiff_t>(i * per_frame));
  values.resize(frames.size() * per_frame);
}

void keep_of_sheet(const std::vector<std::size_t>& frames, Sheet& sheet) {
  keep(frames, sheet.at(1, 0), sheet.position_m);
  for (ClipTrack& clip : sheet.clips) keep(frames, 1, clip.pose);
  for (CordTrack& cord : sheet.cords) {
    keep(frames, 1, cord.tension_N);
    keep(frames, 1, cord.direction);
  }
  for (SupportTrack& support : sheet.supports) {
    keep(frames, 1, support.edge_m);
    keep(frames, 1, support.pose);
  }
}

}  // namespace

Expected<Capture> with_runs(Capture capture, const std::vector<int>& numbers) {
  std::vector<int> index(capture.runs.size(), -1);
  std::vector<Run> runs;
  for (std::size_t r = 0; r < capture.runs.size(); ++r) {
    if (std::ranges::find(numbers, capture.runs[r].number) == numbers.end()) continue;
    index[r] = static_cast<int>(runs.size());
    runs.push_back(capture.runs[r]);
  }
  for (const int number : numbers) {
    if (std::ranges::find(runs, number, &Run::number) != runs.end()) continue;
    std::string there;
    for (const Run& run : capture.runs)
      there += (there.empty() ? "" : ", ") + std::to_string(run.number);
    return bad_input("there is no run " + std::to_string(number) + ", only " + there);
  }
  std::vector<std::size_t> frames;
  for (std::size_t f = 0; f < capture.frame_count(); ++f)
    if (index[static_cast<std::size_t>(capture.run[f])] >= 0) frames.push_back(f);
  if (frames.empty()) return bad_input("no run is left");
  if (runs.size() < capture.runs.size()) {
    capture.title += runs.size() == 1 ? ", run " : ", runs ";
    for (std::size_t r = 0; r < runs.size(); ++r)
      capture.title += (r > 0 ? ", " : "") + std::to_string(runs[r].number);
  }
  capture.runs = std::move(runs);
  keep(frames, 1, capture.run);
  for (int& run : capture.run) run = index[static_cast<std::size_t>(run)];
  keep(frames, 1, capture.frame);
  keep(frames, 1, capture.phase);
  keep(frames, 1, capture.branch);
  keep(frames, 1, capture.time_s);
  for (Channel& channel : capture.channels) {
    keep(frames, 1, channel.values);
    keep(frames, 1, channel.sigma_per_frame);
  }
  if (capture.sheet) keep_of_sheet(frames, *capture.sheet);
  return capture;
}

}  // namespace tenter::capture
