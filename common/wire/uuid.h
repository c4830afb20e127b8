// SPDX-License-Identifier: Apache-2.0
// Sixteen octets that name a client, a server, a request, a transfer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tenter::wire {

using Uuid = std::array<std::uint8_t, 16>;

/// From the kernel's random source.
Uuid random_uuid();

/// 32 lower-case hex digits.
std::string to_text(const Uuid& id);

/// Takes hex digits of either case, with or without dashes.
std::optional<Uuid> parse_uuid(std::string_view text);

/// The identifier itself if the text is one, else the first octets of its SHA-256: for names that
/// others made.
Uuid uuid_of(std::string_view text);

}  // namespace tenter::wire
