// SPDX-License-Identifier: Apache-2.0
#include "common/mesh_text/words.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace tenter::mesh_text {

bool Lines::next() {
  if (position_ >= text_.size()) return false;
  const std::size_t end = text_.find('\n', position_);
  line_ = text_.substr(position_, end == std::string_view::npos ? end : end - position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

tl::unexpected<Error> Lines::fail(const char* what, const std::string& reason) const {
  return bad_input(std::string(what) + ", line " + std::to_string(number_) + ": " + reason);
}

std::string_view Words::next() {
  const std::size_t begin = rest_.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    rest_ = {};
    return {};
  }
  const std::size_t end = rest_.find_first_of(" \t", begin);
  const std::string_view word =
      rest_.substr(begin, end == std::string_view::npos ? end : end - begin);
  rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end);
  return word;
}

namespace {

template <class Number>
bool parse(std::string_view word, Number& value) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto [stop, code] = std::from_chars(word.data(), end, value);
  return !word.empty() && code == std::errc{} && stop == end;
}

}  // namespace

bool to_number(std::string_view word, double& value) {
  return parse(word, value) && std::isfinite(value);
}

bool to_integer(std::string_view word, std::int64_t& value) {
  return parse(word, value);
}

std::string quoted(std::string_view word) {
  std::string shown = "'";
  for (const char c : word.substr(0, 40)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (word.size() > 40 ? "...'" : "'");
}

}  // namespace tenter::mesh_text
