// SPDX-License-Identifier: Apache-2.0
// Private: reads a capture file with the first failure kept, so that the layout reads as a list.
//
//   Source in(file);
//   capture.title = in.text(kEntry + "/title");
//   if (!in.ok()) return tl::unexpected(in.error());
//
// After a failure everything reads as empty. One thread.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/vocabulary.h"
#include "common/h5/reader.h"

namespace tenter::capture::layout {

using h5::H5Reader;

class Source {
 public:
  explicit Source(const H5Reader& file) : file_(file) {}

  bool ok() const { return !error_; }
  const Error& error() const { return *error_; }
  void complain(const std::string& object, const std::string& what) {
    if (ok()) error_ = file_.complaint(object, what).value();
  }

  std::string text(const std::string& path) { return take(file_.text(path)); }
  double number(const std::string& path) { return take(file_.number(path)); }
  std::int64_t integer(const std::string& path) { return take(file_.integer(path)); }
  std::vector<double> doubles(const std::string& path) { return take(file_.doubles(path)); }
  std::vector<int> ints(const std::string& path) { return take(file_.ints(path)); }
  std::vector<std::string> texts(const std::string& path) { return take(file_.texts(path)); }
  std::string text_attribute(const std::string& path, const std::string& name) {
    return take(file_.text_attribute(path, name));
  }
  double number_attribute(const std::string& path, const std::string& name) {
    return take(file_.number_attribute(path, name));
  }
  std::int64_t integer_attribute(const std::string& path, const std::string& name) {
    return take(file_.integer_attribute(path, name));
  }
  /// A table of this shape; 0 stands for any length. The shape is held against it before anything
  /// is read.
  H5Reader::Table table(const std::string& path, const std::vector<std::uint64_t>& shape) {
    const std::vector<std::uint64_t> got = take(file_.shape(path));
    bool fits = got.size() == shape.size();
    for (std::size_t i = 0; fits && i < shape.size(); ++i)
      fits = shape[i] == 0 || shape[i] == got[i];
    if (!fits)
      complain(path, "has the shape " + words_of(got) + " where " + words_of(shape) + " is needed");
    return ok() ? take(file_.table(path)) : H5Reader::Table{};
  }
  std::vector<std::string> members(const std::string& path) { return take(file_.members(path)); }

  bool has(const std::string& path) { return ok() && take(file_.has(path)); }
  bool has_attribute(const std::string& path, const std::string& name) {
    return ok() && take(file_.has_attribute(path, name));
  }
  std::optional<double> optional_number(const std::string& path, const std::string& unit) {
    if (!has(path)) return std::nullopt;
    check_unit(path, unit);
    return number(path);
  }
  void check_unit(const std::string& path, const std::string& unit) {
    const std::string got = text_attribute(path, "units");
    if (ok() && got != unit)
      complain(path, "has units \"" + got + "\" where the layout says \"" + unit + "\"");
  }
  template <class Enum>
  Enum word(const std::string& path, const std::string& text) {
    const std::optional<Enum> value = from_word<Enum>(text);
    if (!value) complain(path, "is \"" + text + "\", not one of " + words<Enum>());
    return value.value_or(Enum{});
  }

 private:
  static std::string words_of(const std::vector<std::uint64_t>& shape) {
    std::string words;
    for (const std::uint64_t length : shape)
      words += (words.empty() ? "" : " x ") + (length == 0 ? "any" : std::to_string(length));
    return "[" + words + "]";
  }

  template <class T>
  T take(Expected<T> value) {
    if (value) return std::move(*value);
    if (ok()) error_ = value.error();
    return T{};
  }

  const H5Reader& file_;
  std::optional<Error> error_;
};

/// The layout's own objects inside a group; anything else is listed as ignored.
inline void list_ignored(Source& in, const std::string& group, const std::set<std::string>& known,
                         std::vector<std::string>* ignored) {
  if (!ignored || !in.ok()) return;
  for (const std::string& name : in.members(group))
    if (known.count(name) == 0) ignored->push_back((group == "/" ? "" : group) + "/" + name);
}

}  // namespace tenter::capture::layout
