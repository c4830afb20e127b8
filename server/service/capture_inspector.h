// SPDX-License-Identifier: GPL-3.0-or-later
// Reads an uploaded capture in a process of its own: a hostile file costs that process, and what
// reading a large one takes in memory is gone with it. Mesh files of scenes (OBJ, PLY, MSH) come
// the same way and are known by how they begin.
//
//   config.inspect_capture = capture_inspector("/proc/self/exe");   // the daemon's side
//   if (inspecting) return inspect_main(file);                      // the process's side: one line
//   of JSON
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/base/error.h"
#include "server/jobs/job_service.h"

namespace tenter::service {

/// Starts `program --inspect-capture FILE` for each file. Any thread.
std::function<Expected<jobs::CaptureSummary>(const std::filesystem::path&)> capture_inspector(
    std::filesystem::path program);

/// Prints {"ok": true, "kind", "title", "summary"} or {"ok": false, "error", "message"}; returns
/// the exit code.
int inspect_main(const std::string& file);

}  // namespace tenter::service
