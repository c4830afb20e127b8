// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of the queue's database, how an older one becomes the present one, and what to do with
// a damaged one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/queue/sqlite.h"

namespace tenter::jobs {

/// Opens the file, applies the migrations that it lacks, and returns the writing connection. A
/// damaged file is moved aside (FILE.damaged-N) and every row that can still be read is copied into
/// a new one; `findings` tells. A file of a newer program is refused.
Expected<std::unique_ptr<Database>> open_queue_database(const std::filesystem::path& file,
                                                        std::vector<std::string>& findings);

}  // namespace tenter::jobs
