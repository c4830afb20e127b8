// SPDX-License-Identifier: Apache-2.0
// Shows how long work goes: a line drawn over and over on a terminal, with what the worker tells of
// itself below it; single lines now and then elsewhere.
//
//   ProgressDisplay display(std::cerr, isatty(2), terminal_width(2));
//   client.watch(job, [&](const client::JobUpdate& u) { display.show(u); });
//   display.finish();
//
// One thread at a time.
#pragma once

#include <chrono>
#include <ostream>
#include <string>
#include <vector>

#include "client/api/client.h"

namespace tenter::cli {

class ProgressDisplay {
 public:
  using Clock = std::chrono::steady_clock;

  ProgressDisplay(std::ostream& out, bool terminal, int width);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void show(const client::JobUpdate& update, Clock::time_point now = Clock::now());
  void show_transfer(const std::string& what, const client::TransferProgress& progress,
                     Clock::time_point now = Clock::now());

  /// Leaves the terminal as it was before: the drawn line disappears.
  void finish();

 private:
  void draw(const std::string& line, const std::vector<std::string>& below,
            const std::string& milestone, Clock::time_point now);
  /// Clears what was drawn.
  std::string clearing() const;

  std::ostream& out_;
  bool terminal_;
  int width_;
  bool drawn_ = false;
  std::size_t below_ = 0;  ///< lines that were drawn below the first
  Clock::time_point last_{};
  std::string last_milestone_;
  Clock::time_point transfer_start_{};
  std::string transfer_;
  double bytes_before_ = 0.0;
};

/// What a line about a job says: "job 17  running  screen internal_friction  iteration 12  cost
/// 0.0123  [####----] 45 %  12 s, about 14 s left"; what does not fit into `width` is cut.
std::string job_line(const client::JobUpdate& update, int width);

/// The detail of the stage, broken between its values, where job_line() has no room for it; at most
/// kDetailLines.
inline constexpr std::size_t kDetailLines = 5;
std::vector<std::string> detail_lines(const client::JobUpdate& update, int width);

}  // namespace tenter::cli
