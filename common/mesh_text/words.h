// SPDX-License-Identifier: Apache-2.0
// Lines, words and numbers of a text, without copies: what the readers of this folder share.
//
//   Lines lines(text);
//   while (lines.next()) { Words words(lines.line()); ... }
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/error.h"

namespace tenter::mesh_text {

/// Goes through a text line by line; line ends may be \n or \r\n.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  bool next();
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }  ///< of the present line, from 1
  std::size_t position() const { return position_; }
  std::size_t remaining() const { return text_.size() - position_; }

  /// bad_input: "<what>, line <number>: <reason>".
  tl::unexpected<Error> fail(const char* what, const std::string& reason) const;

 private:
  std::string_view text_;
  std::string_view line_;
  std::size_t position_ = 0;
  std::size_t number_ = 0;
};

/// Goes through the words of a line; an empty word is the end.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next();

 private:
  std::string_view rest_;
};

/// The whole word as a finite number, or false.
bool to_number(std::string_view word, double& value);
bool to_integer(std::string_view word, std::int64_t& value);

/// A word for a message: printable, at most 40 characters, in quotes.
std::string quoted(std::string_view word);

}  // namespace tenter::mesh_text
