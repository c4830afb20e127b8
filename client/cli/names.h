// SPDX-License-Identifier: Apache-2.0
// How a user names things: jobs by number or "last", captures by file, hash or the beginning of it,
// models by preset or file.
#pragma once

#include <string>

#include "client/api/client.h"
#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::cli {

/// A job's number as the server knows it; "last" is the newest job of the user.
Expected<std::string> resolve_job(client::Client& client, const std::string& name);

/// The whole SHA-256 for one or for its first 6 or more digits.
Expected<std::string> resolve_capture(client::Client& client, const std::string& name);

/// 6 to 64 hexadecimal digits.
bool looks_like_hash(const std::string& name);

/// A shipped model by name, or a model document by file ("-": standard input).
Expected<model::Model> load_model(const std::string& name_or_file);

/// An error about sending a file, naming the file.
Error about_file(const std::string& file, Error error);

/// A whole file as text ("-": standard input), at most `max_bytes`.
Expected<std::string> read_input(const std::string& path, std::size_t max_bytes);

}  // namespace tenter::cli
