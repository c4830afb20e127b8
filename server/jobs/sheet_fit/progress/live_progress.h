// SPDX-License-Identifier: GPL-3.0-or-later
// What a running fit says: stage, frame being solved, cost, iteration, the parameters that are
// tried, and of a curve of several control points its shape so far.
//
//   stage "bend_u"  detail "frame 12 of 40, bend left; bend_weft 0.00021 0.00018 ▁▃▅▇█"
//
// Of stages that run side by side one is told of, until it falls silent. Any thread may call. The
// rate is the worker's matter, but words are made at most 20 times a second.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>

#include "server/estimation/staged/staged_fit.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

class LiveProgress {
 public:
  explicit LiveProgress(std::function<void(const JobProgress&)> report)
      : report_(std::move(report)) {}

  void begin(std::size_t stages, std::size_t done);
  void frame(const estimation::StageFrame& frame);
  void iteration(const estimation::StageProgress& progress);
  void stages_done(std::size_t done);

 private:
  double fraction() const;
  /// Whether this stage is the one that is told of; it becomes so where there is none.
  bool is_told(const std::string& stage, std::chrono::steady_clock::time_point now);

  std::function<void(const JobProgress&)> report_;
  std::mutex mutex_;
  std::size_t stages_ = 1;
  std::size_t done_ = 0;
  JobProgress last_;
  std::string told_;  ///< stage; "": the next that comes
  std::chrono::steady_clock::time_point heard_{};
  std::chrono::steady_clock::time_point next_{};
};

inline constexpr std::size_t kMostWords = 1200;  ///< bytes of values_in_words()

/// "weft 81.2 90.1 ▁▂▄▆█, shear 4.3": free parameters by term, and the stress of curves over
/// their range, each as a share of its own largest. Terms that are too many are left out ("...").
std::string values_in_words(const model::Model& model, const Eigen::VectorXd& parameters);

}  // namespace tenter::jobs
