// SPDX-License-Identifier: GPL-3.0-or-later
// What daemon and worker say to each other: an order file on the way in; lines of JSON on
// descriptor 3, and the exit code, on the way back.
//
//   {"heartbeat": true}                                      every WorkOrder::heartbeat; a stopped
//   process sends none
//   {"progress": {"stage", "detail", "iteration", "cost", "fraction"}}
//   {"error": {"kind", "message"}}                           once, before exit code kWorkerFailed
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "common/base/error.h"
#include "server/jobs/worker/executor.h"

namespace tenter::jobs {

inline constexpr int kWorkerPipe = 3;
inline constexpr std::size_t kMaxWorkerLine = 16384;

inline constexpr int kWorkerFinished = 0;
inline constexpr int kWorkerBadOrder = 10;
inline constexpr int kWorkerFailed = 11;
inline constexpr int kWorkerOutOfMemory = 12;
inline constexpr int kWorkerCancelled = 13;

struct ReceivedOrder {
  WorkOrder order;
  int parent = 0;  ///< process id of the daemon; the worker dies with it
};

std::string write_order(const WorkOrder& order, int parent);
Expected<ReceivedOrder> read_order(const std::filesystem::path& file);

struct Heartbeat {};
using WorkerLine = std::variant<Heartbeat, JobProgress, Error>;

std::string write_line(const WorkerLine& line);  ///< with the line end
/// None for anything else: a worker may be broken, the daemon not.
std::optional<WorkerLine> read_line(std::string_view text);

}  // namespace tenter::jobs
