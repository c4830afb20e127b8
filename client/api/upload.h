// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stop_token>

#include "client/api/client.h"
#include "client/api/connection.h"

namespace tenter::client {

/// Sends what the server does not have, at most its credit at a time; begins anew where it stopped
/// when chunks or acknowledgements are lost or the server was started again. Gives up after
/// ClientOptions::timeout without progress.
Expected<UploadResult> upload(Connection& connection, const std::filesystem::path& path,
                              const TransferCallback& progress, const std::stop_token& stop);

}  // namespace tenter::client
