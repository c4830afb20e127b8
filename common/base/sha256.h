// SPDX-License-Identifier: Apache-2.0
// SHA-256 of bytes and of files, as 64 lower-case hex digits: the name of everything in the
// content-addressed store.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/error.h"

namespace tenter {

std::string sha256_hex(std::string_view bytes);

/// Reads the file once in pieces; an unreadable file is an Error that names it.
Expected<std::string> sha256_file(const std::filesystem::path& path);

/// 64 characters of 0-9a-f.
bool is_sha256(std::string_view text);

}  // namespace tenter
