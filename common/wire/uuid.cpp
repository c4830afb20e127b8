// SPDX-License-Identifier: Apache-2.0
#include "common/wire/uuid.h"

#include <sys/random.h>

#include <cstdlib>

#include "common/base/sha256.h"

namespace tenter::wire {
namespace {

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

Uuid random_uuid() {
  Uuid id{};
  if (getrandom(id.data(), id.size(), 0) != static_cast<ssize_t>(id.size())) std::abort();
  return id;
}

std::string to_text(const Uuid& id) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(32);
  for (std::uint8_t octet : id) {
    text += kDigits[octet >> 4];
    text += kDigits[octet & 15];
  }
  return text;
}

std::optional<Uuid> parse_uuid(std::string_view text) {
  Uuid id{};
  std::size_t digits = 0;
  for (char c : text) {
    if (c == '-') continue;
    const int value = hex_value(c);
    if (value < 0 || digits == 32) return std::nullopt;
    id[digits / 2] = static_cast<std::uint8_t>(id[digits / 2] << 4 | value);
    ++digits;
  }
  if (digits != 32) return std::nullopt;
  return id;
}

Uuid uuid_of(std::string_view text) {
  if (auto id = parse_uuid(text)) return *id;
  return *parse_uuid(sha256_hex(text).substr(0, 32));
}

}  // namespace tenter::wire
