// SPDX-License-Identifier: Apache-2.0
// The data of a PLY file. A Rows object reads one row of an element after the other, from text or
// from bytes, into a flat list of values; every number is exact in a double. Before an element is
// read, its count is held against the bytes that are left.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>

#include "common/mesh_text/mesh_text.h"
#include "common/mesh_text/ply_header.h"
#include "common/mesh_text/words.h"

namespace tenter::mesh_text {

namespace {

/// One row: the values of each property, one after the other.
struct Row {
  std::vector<double> values;
  std::vector<std::size_t> begin;  ///< of each property in values; one more at the end
};

template <class T>
double value_of(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double decode(PlyType type, const char* bytes, bool swapped) {
  char own[8];
  const std::size_t size = size_of(type);
  if (swapped)
    std::reverse_copy(bytes, bytes + size, own);
  else
    std::copy(bytes, bytes + size, own);
  switch (type) {
    case PlyType::int8:
      return value_of<std::int8_t>(own);
    case PlyType::uint8:
      return value_of<std::uint8_t>(own);
    case PlyType::int16:
      return value_of<std::int16_t>(own);
    case PlyType::uint16:
      return value_of<std::uint16_t>(own);
    case PlyType::int32:
      return value_of<std::int32_t>(own);
    case PlyType::uint32:
      return value_of<std::uint32_t>(own);
    case PlyType::float32:
      return value_of<float>(own);
    case PlyType::float64:
      return value_of<double>(own);
  }
  return 0.0;
}

class Rows {
 public:
  Rows(std::string_view bytes, Lines lines, PlyFormat format)
      : bytes_(bytes), lines_(lines), position_(lines.position()), format_(format) {}

  /// bad_input where so many rows cannot stand in the bytes that are left.
  Expected<void> begin(const PlyElement& element) {
    element_ = &element;
    row_ = 0;
    if (element.count == 0) return {};
    std::uint64_t least = 0;
    for (const PlyProperty& property : element.properties)
      least += format_ == PlyFormat::ascii
                   ? 2  // a digit and what ends it
                   : size_of(property.list ? property.count_type : property.type);
    if (least == 0) return bad_input("PLY: element " + quoted(element.name) + " has no properties");
    const std::uint64_t left = remaining() + 1;  // the last line may lack its end
    if (element.count > left / least)
      return bad_input("PLY: " + std::to_string(element.count) + " rows of element " +
                       quoted(element.name) + " cannot stand in the " +
                       std::to_string(remaining()) + " bytes that are left");
    return {};
  }

  Expected<void> next(Row& row) {
    row.values.clear();
    row.begin.clear();
    if (format_ == PlyFormat::ascii && !lines_.next()) return fail("the text ends here");
    Words words(lines_.line());
    for (const PlyProperty& property : element_->properties) {
      row.begin.push_back(row.values.size());
      std::uint64_t count = 1;
      if (property.list) {
        double length = 0.0;
        if (auto read = value(property.count_type, words, length); !read) return read;
        if (length < 0.0 || length != std::floor(length))
          return fail("a list of length " + std::to_string(length));
        if (length > static_cast<double>(remaining() + lines_.line().size()))
          return fail("a list of more values than there are bytes left");
        count = static_cast<std::uint64_t>(length);
      }
      for (std::uint64_t k = 0; k < count; ++k) {
        double x = 0.0;
        if (auto read = value(property.type, words, x); !read) return read;
        row.values.push_back(x);
      }
    }
    row.begin.push_back(row.values.size());
    if (format_ == PlyFormat::ascii && !words.next().empty())
      return fail("more values than properties");
    ++row_;
    return {};
  }

  /// bad_input that names the line, or element and row in binary data.
  tl::unexpected<Error> fail(const std::string& reason) const {
    if (format_ == PlyFormat::ascii) return lines_.fail("PLY", reason);
    return bad_input("PLY, row " + std::to_string(row_) + " of element " + quoted(element_->name) +
                     ": " + reason);
  }

 private:
  std::size_t remaining() const {
    return format_ == PlyFormat::ascii ? lines_.remaining() : bytes_.size() - position_;
  }

  Expected<void> value(PlyType type, Words& words, double& out) {
    if (format_ == PlyFormat::ascii) {
      const std::string_view word = words.next();
      if (word.empty()) return fail("fewer values than properties");
      if (!to_number(word, out)) return fail(quoted(word) + " is not a finite number");
      return {};
    }
    if (size_of(type) > remaining()) return fail("the bytes end here");
    const bool little = format_ == PlyFormat::little_endian;
    out = decode(type, bytes_.data() + position_,
                 little != (std::endian::native == std::endian::little));
    position_ += size_of(type);
    if (!std::isfinite(out)) return fail("a value is not finite");
    return {};
  }

  std::string_view bytes_;
  Lines lines_;
  std::size_t position_;
  PlyFormat format_;
  const PlyElement* element_ = nullptr;
  std::uint64_t row_ = 0;
};

/// Index of the first scalar property of one of these names, or -1.
int find(const PlyElement& element, std::initializer_list<std::string_view> names, bool list) {
  for (std::size_t k = 0; k < element.properties.size(); ++k)
    for (const std::string_view name : names)
      if (element.properties[k].name == name && element.properties[k].list == list)
        return static_cast<int>(k);
  return -1;
}

Expected<void> read_vertices(Rows& rows, const PlyElement& element, ReadMesh& mesh) {
  const int place[5] = {find(element, {"x"}, false), find(element, {"y"}, false),
                        find(element, {"z"}, false),
                        find(element, {"u", "s", "texture_u", "texture_s"}, false),
                        find(element, {"v", "t", "texture_v", "texture_t"}, false)};
  if (place[0] < 0 || place[1] < 0 || place[2] < 0)
    return bad_input("PLY: element 'vertex' lacks x, y or z");
  if (element.count > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
    return bad_input("PLY: more nodes than an index can name");
  const bool textured = place[3] >= 0 && place[4] >= 0;
  const auto count = static_cast<Eigen::Index>(element.count);
  mesh.positions_m.resize(3, count);
  mesh.texture.resize(2, textured ? count : 0);
  Row row;
  for (Eigen::Index n = 0; n < count; ++n) {
    if (auto read = rows.next(row); !read) return read;
    const auto at = [&](int k) {
      return row.values[row.begin[static_cast<std::size_t>(place[k])]];
    };
    mesh.positions_m.col(n) << at(0), at(1), at(2);
    if (textured) mesh.texture.col(n) << at(3), at(4);
  }
  return {};
}

Expected<void> read_faces(Rows& rows, const PlyElement& element, int nodes, ReadMesh& mesh) {
  const int list = find(element, {"vertex_indices", "vertex_index"}, true);
  if (list < 0) return bad_input("PLY: element 'face' lacks the list vertex_indices");
  Row row;
  for (std::uint64_t face = 0; face < element.count; ++face) {
    if (auto read = rows.next(row); !read) return read;
    const std::size_t first = row.begin[static_cast<std::size_t>(list)];
    const std::size_t corners = row.begin[static_cast<std::size_t>(list) + 1] - first;
    if (corners < 3 || corners > 4)
      return rows.fail("a face of " + std::to_string(corners) + " corners");
    std::array<int, 4> node{};
    for (std::size_t k = 0; k < corners; ++k) {
      const double index = row.values[first + k];
      if (index < 0.0 || index >= nodes || index != std::floor(index))
        return rows.fail("a face names node " + std::to_string(index) + " of " +
                         std::to_string(nodes));
      node[k] = static_cast<int>(index);
    }
    mesh.triangles.push_back({node[0], node[1], node[2]});
    if (corners == 4) mesh.triangles.push_back({node[0], node[2], node[3]});
  }
  return {};
}

Expected<void> pass_over(Rows& rows, const PlyElement& element) {
  Row row;
  for (std::uint64_t k = 0; k < element.count; ++k)
    if (auto read = rows.next(row); !read) return read;
  return {};
}

/// How many nodes the file has, known from its header: faces may come first.
Expected<int> declared_nodes(const PlyHeader& header) {
  for (const PlyElement& element : header.elements)
    if (element.name == "vertex")
      return static_cast<int>(std::min<std::uint64_t>(
          element.count, static_cast<std::uint64_t>(std::numeric_limits<int>::max())));
  return bad_input("PLY: no element 'vertex'");
}

}  // namespace

Expected<ReadMesh> read_ply(std::string_view bytes, double metres_per_unit) {
  Lines lines(bytes);
  const Expected<PlyHeader> header = read_ply_header(lines);
  if (!header) return tl::unexpected(header.error());
  const Expected<int> nodes = declared_nodes(*header);
  if (!nodes) return tl::unexpected(nodes.error());
  ReadMesh mesh;
  Rows rows(bytes, lines, header->format);
  std::vector<std::string_view> seen;
  for (const PlyElement& element : header->elements) {
    if (std::find(seen.begin(), seen.end(), element.name) != seen.end())
      return bad_input("PLY: element " + quoted(element.name) + " twice");
    seen.push_back(element.name);
    Expected<void> read = rows.begin(element);
    if (read && element.name == "vertex")
      read = read_vertices(rows, element, mesh);
    else if (read && element.name == "face")
      read = read_faces(rows, element, *nodes, mesh);
    else if (read)
      read = pass_over(rows, element);
    if (!read) return tl::unexpected(read.error());
  }
  if (mesh.triangles.empty()) return bad_input("PLY: no faces");
  mesh.positions_m *= metres_per_unit;
  return mesh;
}

Expected<ReadMesh> read_surface_text(std::string_view bytes, double metres_per_unit) {
  const bool ply = bytes.starts_with("ply\n") || bytes.starts_with("ply\r");
  return ply ? read_ply(bytes, metres_per_unit) : read_obj(bytes, metres_per_unit);
}

}  // namespace tenter::mesh_text
