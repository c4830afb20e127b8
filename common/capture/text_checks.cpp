// SPDX-License-Identifier: Apache-2.0
#include "common/capture/text_checks.h"

#include <algorithm>
#include <cctype>
#include <cstdint>

namespace tenter::capture {

namespace {

constexpr std::size_t kMaxText = 32000;  // fits an HDF5 object header

}  // namespace

std::string quoted(const std::string& text) {
  return "\"" + text + "\"";
}

bool well_formed(const std::string& name) {
  return !name.empty() && name.size() <= 200 &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return c < 128 && (std::isalnum(c) != 0 || c == '_'); });
}

std::string trouble_in(const std::string& text) {
  if (text.size() > kMaxText) return "is longer than " + std::to_string(kMaxText) + " bytes";
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if ((lead < 0x20 && lead != '\n' && lead != '\t') || lead == 0x7f)
      return "holds a control character";
    const std::size_t length = lead < 0x80   ? 1
                               : lead < 0xc2 ? 0
                               : lead < 0xe0 ? 2
                               : lead < 0xf0 ? 3
                               : lead < 0xf5 ? 4
                                             : 0;
    if (length == 0 || i + length > text.size()) return "is not valid UTF-8";
    std::uint32_t code = length == 1 ? lead : lead & (0xffU >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xc0U) != 0x80U) return "is not valid UTF-8";
      code = code << 6 | (next & 0x3fU);
    }
    const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    if (overlong || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
      return "is not valid UTF-8";
    i += length;
  }
  return "";
}

std::string at_frame(const Capture& capture, std::size_t i) {
  return "run " + std::to_string(capture.runs[static_cast<std::size_t>(capture.run[i])].number) +
         ", frame " + std::to_string(capture.frame[i]);
}

}  // namespace tenter::capture
