// SPDX-License-Identifier: Apache-2.0
// A whole file as bytes, with a limit so that a wrong path cannot fill the memory.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/error.h"

namespace tenter {

/// not_found where there is no such file; bad_input where it is no regular file, too large or
/// unreadable.
Expected<std::string> read_text_file(const std::string& path, std::size_t max_bytes);

}  // namespace tenter
