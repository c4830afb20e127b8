// SPDX-License-Identifier: GPL-3.0-or-later
// The configuration file of the daemon: a JSON object, every key optional, unknown keys refused.
//
//   {"domain": 42, "name": "lab", "interfaces": ["127.0.0.1"], "workers": 4, "log_level": "info",
//    "limits": {"default_time_s": 3600, "max_time_s": 604800, "default_memory_bytes": 4294967296,
//               "max_memory_bytes": 68719476736, "capture_bytes": 17179869184, "attempts": 3},
//    "quota": {"queued": 2000, "running": 64, "stored_bytes": 53687091200}}
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/job_service.h"

namespace tenter::service {

struct DaemonConfig {
  std::optional<int> domain;
  std::string name;
  std::vector<std::string> interfaces;
  std::string log_level = "info";
  jobs::ServiceConfig jobs;
};

/// Errors name the file and the key.
Expected<void> read_daemon_config(const std::filesystem::path& file, DaemonConfig& config);

}  // namespace tenter::service
