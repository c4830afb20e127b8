// SPDX-License-Identifier: Apache-2.0
// Puts bytes at a path so that a reader sees the old file or the whole new one, also after a power
// cut: written to a temporary file in the same folder, synced, renamed over `path`, the folder
// synced. On failure nothing is left behind; a full disk is ErrorKind::no_space.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/error.h"

namespace tenter {

Expected<void> write_atomically(const std::string& path, const void* bytes, std::size_t size);

}  // namespace tenter
