// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "client/api/client.h"
#include "client/api/connection.h"

namespace tenter::client {

/// What to fetch: a file of a job, or a capture.
struct RemoteFile {
  std::string job_id;
  std::string file;     ///< "result.json", "residuals.h5", "frames.h5"
  std::string capture;  ///< SHA-256; then the others are empty
};

/// Asks for portions of eight chunks, two at a time under way, into a file beside the destination;
/// checks its SHA-256, renames it. Returns its size.
Expected<std::uint64_t> download(Connection& connection, const RemoteFile& what,
                                 const std::filesystem::path& destination,
                                 const TransferCallback& progress, const std::stop_token& stop);

}  // namespace tenter::client
