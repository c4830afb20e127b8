// SPDX-License-Identifier: GPL-3.0-or-later
// Files spoilt at random, for readers that must not mind.
#pragma once

#include <algorithm>
#include <random>
#include <string>

namespace tenter::fault {

/// Bytes changed at random, mostly where the structure is; sometimes cut or grown too.
inline std::string mutated(std::string bytes, std::mt19937& generator) {
  const unsigned count = 1 + generator() % 6;
  for (unsigned i = 0; i < count; ++i) {
    const std::size_t range =
        generator() % 5 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 8192);
    static constexpr unsigned char kNasty[] = {0x00, 0xff, 0x7f, 0x80};
    const unsigned choice = generator() % 5;
    bytes[generator() % range] = static_cast<char>(choice < 4 ? kNasty[choice] : generator() % 256);
  }
  if (generator() % 10 == 0) bytes.resize(100 + generator() % (bytes.size() - 100));
  if (generator() % 20 == 0) bytes.append(generator() % 5000, '\x55');
  return bytes;
}

}  // namespace tenter::fault
