// SPDX-License-Identifier: Apache-2.0
#include "common/mesh_text/ply_header.h"

#include <array>
#include <utility>

namespace tenter::mesh_text {

namespace {

struct TypeName {
  std::string_view name;
  PlyType type;
};

constexpr std::array<TypeName, 16> kTypes = {{{"char", PlyType::int8},
                                              {"int8", PlyType::int8},
                                              {"uchar", PlyType::uint8},
                                              {"uint8", PlyType::uint8},
                                              {"short", PlyType::int16},
                                              {"int16", PlyType::int16},
                                              {"ushort", PlyType::uint16},
                                              {"uint16", PlyType::uint16},
                                              {"int", PlyType::int32},
                                              {"int32", PlyType::int32},
                                              {"uint", PlyType::uint32},
                                              {"uint32", PlyType::uint32},
                                              {"float", PlyType::float32},
                                              {"float32", PlyType::float32},
                                              {"double", PlyType::float64},
                                              {"float64", PlyType::float64}}};

bool to_type(std::string_view word, PlyType& type) {
  for (const TypeName& known : kTypes)
    if (known.name == word) {
      type = known.type;
      return true;
    }
  return false;
}

Expected<void> read_format(const Lines& lines, Words& words, PlyFormat& format) {
  const std::string_view name = words.next();
  if (name == "ascii")
    format = PlyFormat::ascii;
  else if (name == "binary_little_endian")
    format = PlyFormat::little_endian;
  else if (name == "binary_big_endian")
    format = PlyFormat::big_endian;
  else
    return lines.fail("PLY", "unknown format " + quoted(name));
  if (words.next() != "1.0") return lines.fail("PLY", "only version 1.0 is known");
  return {};
}

Expected<void> read_element(const Lines& lines, Words& words, PlyHeader& header) {
  PlyElement element;
  element.name = std::string(words.next());
  const std::string_view word = words.next();
  std::int64_t count = 0;
  if (element.name.empty() || !to_integer(word, count) || count < 0)
    return lines.fail("PLY", "an element needs a name and a count, not " + quoted(word));
  element.count = static_cast<std::uint64_t>(count);
  header.elements.push_back(std::move(element));
  return {};
}

Expected<void> read_property(const Lines& lines, Words& words, PlyHeader& header) {
  if (header.elements.empty()) return lines.fail("PLY", "a property before any element");
  PlyProperty property;
  std::string_view type = words.next();
  if (type == "list") {
    property.list = true;
    const std::string_view count_type = words.next();
    if (!to_type(count_type, property.count_type) || property.count_type >= PlyType::float32)
      return lines.fail("PLY", quoted(count_type) + " is no type of a list's length");
    type = words.next();
  }
  if (!to_type(type, property.type)) return lines.fail("PLY", "unknown type " + quoted(type));
  property.name = std::string(words.next());
  if (property.name.empty()) return lines.fail("PLY", "a property without a name");
  header.elements.back().properties.push_back(std::move(property));
  return {};
}

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      return 8;
  }
  return 8;
}

Expected<PlyHeader> read_ply_header(Lines& lines) {
  PlyHeader header;
  if (!lines.next() || lines.line() != "ply") return bad_input("PLY, line 1: not 'ply'");
  bool formatted = false;
  while (lines.next()) {
    Words words(lines.line());
    const std::string_view keyword = words.next();
    Expected<void> read;
    if (keyword == "end_header") {
      if (!formatted) return lines.fail("PLY", "the header names no format");
      return header;
    }
    if (keyword == "format") {
      read = read_format(lines, words, header.format);
      formatted = true;
    } else if (keyword == "element") {
      read = read_element(lines, words, header);
    } else if (keyword == "property") {
      read = read_property(lines, words, header);
    } else if (keyword != "comment" && keyword != "obj_info") {
      return lines.fail("PLY", "unknown word " + quoted(keyword) + " in the header");
    }
    if (!read) return tl::unexpected(read.error());
  }
  return lines.fail("PLY", "the text ends before end_header");
}

}  // namespace tenter::mesh_text
