// SPDX-License-Identifier: Apache-2.0
// Private: numbers and columns of what `show` prints.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace tenter::capture {

inline std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

inline std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

}  // namespace tenter::capture
