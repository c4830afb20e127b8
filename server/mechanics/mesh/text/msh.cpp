// SPDX-License-Identifier: GPL-3.0-or-later
// Gmsh MSH. Sections stand between $Name and $EndName; 2.2 has one node or element a line, 4.1 has
// blocks of them. Node tags are resolved when all sections are read.
#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "common/mesh_text/words.h"
#include "server/mechanics/mesh/solid_text.h"

namespace tenter::mechanics {

namespace {

using mesh_text::Lines;
using mesh_text::quoted;
using mesh_text::Words;

constexpr const char* kWhat = "MSH";
constexpr std::int64_t kTetrahedron = 4;
constexpr std::int64_t kHexahedron = 5;

/// Points, lines, triangles, quadrilaterals, of first and second order: what a boundary is made of.
constexpr bool of_boundary(std::int64_t type) {
  return type == 15 || (type >= 1 && type <= 3) || (type >= 8 && type <= 10) || type == 16;
}

struct TaggedNode {
  std::int64_t tag = 0;
  Eigen::Vector3d place;
};

struct Element {
  std::size_t line = 0;
  std::size_t count = 0;  ///< of corners
  std::array<std::int64_t, 8> tags{};
};

struct Msh {
  bool blocks = false;  ///< version 4.1
  std::vector<TaggedNode> nodes;
  std::vector<Element> elements;
};

Expected<std::int64_t> integer(const Lines& lines, Words& words, const char* name) {
  std::int64_t value = 0;
  const std::string_view word = words.next();
  if (!mesh_text::to_integer(word, value))
    return lines.fail(kWhat, std::string(name) + " is not an integer: " + quoted(word));
  return value;
}

/// A count that the rest of the text can hold: each thing takes at least two bytes.
Expected<std::int64_t> count(const Lines& lines, Words& words, const char* name) {
  Expected<std::int64_t> value = integer(lines, words, name);
  if (!value) return value;
  if (*value < 0 || static_cast<std::uint64_t>(*value) > lines.remaining() / 2)
    return lines.fail(kWhat, std::string(name) + " " + std::to_string(*value) +
                                 " cannot stand in the " + std::to_string(lines.remaining()) +
                                 " bytes that are left");
  return value;
}

Expected<void> advance(Lines& lines) {
  if (!lines.next()) return lines.fail(kWhat, "the text ends inside a section");
  return {};
}

Expected<Eigen::Vector3d> place(const Lines& lines, Words& words) {
  Eigen::Vector3d x;
  for (int k = 0; k < 3; ++k) {
    const std::string_view word = words.next();
    if (!mesh_text::to_number(word, x[k]))
      return lines.fail(kWhat, "coordinate " + quoted(word) + " is not a finite number");
  }
  return x;
}

Expected<void> end_section(Lines& lines, std::string_view name) {
  if (auto moved = advance(lines); !moved) return moved;
  if (Words(lines.line()).next() != name)
    return lines.fail(kWhat, quoted(name) + " expected, not " + quoted(lines.line()));
  return {};
}

Expected<void> read_format(Lines& lines, Msh& msh) {
  if (auto moved = advance(lines); !moved) return moved;
  Words words(lines.line());
  const std::string_view version = words.next();
  if (version != "2.2" && version != "4.1")
    return lines.fail(kWhat, "version " + quoted(version) + "; 2.2 and 4.1 are known");
  msh.blocks = version == "4.1";
  if (words.next() != "0") return lines.fail(kWhat, "only the ascii form is read");
  return end_section(lines, "$EndMeshFormat");
}

Expected<void> read_nodes_2(Lines& lines, Msh& msh) {
  Words head(lines.line());
  const auto total = count(lines, head, "number of nodes");
  if (!total) return tl::unexpected(total.error());
  for (std::int64_t n = 0; n < *total; ++n) {
    if (auto moved = advance(lines); !moved) return moved;
    Words words(lines.line());
    const auto tag = integer(lines, words, "node tag");
    if (!tag) return tl::unexpected(tag.error());
    const auto x = place(lines, words);
    if (!x) return tl::unexpected(x.error());
    msh.nodes.push_back({*tag, *x});
  }
  return {};
}

Expected<void> read_node_block(Lines& lines, Msh& msh) {
  if (auto moved = advance(lines); !moved) return moved;
  Words head(lines.line());
  for (const char* name : {"dimension", "entity", "parametric flag"})
    if (const auto skipped = integer(lines, head, name); !skipped)
      return tl::unexpected(skipped.error());
  const auto total = count(lines, head, "number of nodes");
  if (!total) return tl::unexpected(total.error());
  const std::size_t first = msh.nodes.size();
  for (std::int64_t n = 0; n < *total; ++n) {
    if (auto moved = advance(lines); !moved) return moved;
    Words words(lines.line());
    const auto tag = integer(lines, words, "node tag");
    if (!tag) return tl::unexpected(tag.error());
    msh.nodes.push_back({*tag, Eigen::Vector3d::Zero()});
  }
  for (std::size_t n = first; n < msh.nodes.size(); ++n) {
    if (auto moved = advance(lines); !moved) return moved;
    Words words(lines.line());
    const auto x = place(lines, words);
    if (!x) return tl::unexpected(x.error());
    msh.nodes[n].place = *x;
  }
  return {};
}

/// The corners of a volume element from the rest of its line; nothing for one of the boundary.
Expected<void> read_corners(const Lines& lines, Words& words, std::int64_t type, Msh& msh) {
  if (of_boundary(type)) return {};
  if (type != kTetrahedron && type != kHexahedron)
    return lines.fail(kWhat, "elements of type " + std::to_string(type) +
                                 " are not known; 4 (tetrahedron) and 5 (hexahedron) are");
  Element element;
  element.line = lines.number();
  element.count = type == kTetrahedron ? 4 : 8;
  for (std::size_t k = 0; k < element.count; ++k) {
    const auto tag = integer(lines, words, "node tag");
    if (!tag) return tl::unexpected(tag.error());
    element.tags[k] = *tag;
  }
  msh.elements.push_back(element);
  return {};
}

Expected<void> read_elements_2(Lines& lines, Msh& msh) {
  Words head(lines.line());
  const auto total = count(lines, head, "number of elements");
  if (!total) return tl::unexpected(total.error());
  for (std::int64_t e = 0; e < *total; ++e) {
    if (auto moved = advance(lines); !moved) return moved;
    Words words(lines.line());
    if (const auto tag = integer(lines, words, "element tag"); !tag)
      return tl::unexpected(tag.error());
    const auto type = integer(lines, words, "element type");
    if (!type) return tl::unexpected(type.error());
    const auto labels = integer(lines, words, "number of tags");
    if (!labels) return tl::unexpected(labels.error());
    if (*labels < 0 || *labels > static_cast<std::int64_t>(lines.line().size()))
      return lines.fail(kWhat, "number of tags " + std::to_string(*labels));
    for (std::int64_t k = 0; k < *labels; ++k) words.next();
    if (auto read = read_corners(lines, words, *type, msh); !read) return read;
  }
  return {};
}

Expected<void> read_element_block(Lines& lines, Msh& msh) {
  if (auto moved = advance(lines); !moved) return moved;
  Words head(lines.line());
  for (const char* name : {"dimension", "entity"})
    if (const auto skipped = integer(lines, head, name); !skipped)
      return tl::unexpected(skipped.error());
  const auto type = integer(lines, head, "element type");
  if (!type) return tl::unexpected(type.error());
  const auto total = count(lines, head, "number of elements");
  if (!total) return tl::unexpected(total.error());
  for (std::int64_t e = 0; e < *total; ++e) {
    if (auto moved = advance(lines); !moved) return moved;
    Words words(lines.line());
    if (const auto tag = integer(lines, words, "element tag"); !tag)
      return tl::unexpected(tag.error());
    if (auto read = read_corners(lines, words, *type, msh); !read) return read;
  }
  return {};
}

template <class Plain, class Block>
Expected<void> read_section(Lines& lines, Msh& msh, Plain plain, Block block) {
  if (auto moved = advance(lines); !moved) return moved;
  if (!msh.blocks) return plain(lines, msh);
  Words head(lines.line());
  const auto blocks = count(lines, head, "number of blocks");
  if (!blocks) return tl::unexpected(blocks.error());
  for (std::int64_t b = 0; b < *blocks; ++b)
    if (auto read = block(lines, msh); !read) return read;
  return {};
}

Expected<void> pass_over(Lines& lines, const std::string& end) {
  do {
    if (auto moved = advance(lines); !moved) return moved;
  } while (Words(lines.line()).next() != end);
  return {};
}

Expected<Msh> read_sections(std::string_view bytes) {
  Msh msh;
  Lines lines(bytes);
  bool known = false;
  while (lines.next()) {
    const std::string_view name = Words(lines.line()).next();
    if (name.empty()) continue;
    Expected<void> read;
    if (name == "$MeshFormat") {
      known = true;
      read = read_format(lines, msh);
    } else if (!known || !name.starts_with('$')) {
      return lines.fail(kWhat, (known ? "a section" : "'$MeshFormat'") +
                                   std::string(" expected, not ") + quoted(name));
    } else if (name == "$Nodes") {
      read = read_section(lines, msh, read_nodes_2, read_node_block);
      if (read) read = end_section(lines, "$EndNodes");
    } else if (name == "$Elements") {
      read = read_section(lines, msh, read_elements_2, read_element_block);
      if (read) read = end_section(lines, "$EndElements");
    } else {
      read = pass_over(lines, "$End" + std::string(name.substr(1)));
    }
    if (!read) return tl::unexpected(read.error());
  }
  return msh;
}

constexpr int kUnused = -1;

/// Index of a tag among the sorted nodes, or -1.
std::ptrdiff_t find(const std::vector<TaggedNode>& nodes, std::int64_t tag) {
  const auto at = std::lower_bound(
      nodes.begin(), nodes.end(), tag,
      [](const TaggedNode& node, std::int64_t wanted) { return node.tag < wanted; });
  return at == nodes.end() || at->tag != tag ? -1 : at - nodes.begin();
}

/// Sorts the nodes by tag and numbers those that elements use.
Expected<std::vector<int>> number_nodes(Msh& msh) {
  const auto by_tag = [](const TaggedNode& a, const TaggedNode& b) { return a.tag < b.tag; };
  std::stable_sort(msh.nodes.begin(), msh.nodes.end(), by_tag);
  for (std::size_t n = 1; n < msh.nodes.size(); ++n)
    if (msh.nodes[n].tag == msh.nodes[n - 1].tag)
      return bad_input("MSH: node " + std::to_string(msh.nodes[n].tag) + " twice");
  if (msh.nodes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return bad_input("MSH: more nodes than an index can name");
  std::vector<int> number(msh.nodes.size(), kUnused);
  for (const Element& element : msh.elements)
    for (std::size_t k = 0; k < element.count; ++k) {
      const std::ptrdiff_t at = find(msh.nodes, element.tags[k]);
      if (at < 0)
        return bad_input("MSH, line " + std::to_string(element.line) + ": there is no node " +
                         std::to_string(element.tags[k]));
      number[static_cast<std::size_t>(at)] = 0;
    }
  int next = 0;
  for (int& index : number)
    if (index != kUnused) index = next++;
  return number;
}

}  // namespace

Expected<ReadSolid> read_msh(std::string_view bytes, double metres_per_unit) {
  Expected<Msh> msh = read_sections(bytes);
  if (!msh) return tl::unexpected(msh.error());
  if (msh->elements.empty()) return bad_input("MSH: no tetrahedra or hexahedra");
  const Expected<std::vector<int>> number = number_nodes(*msh);
  if (!number) return tl::unexpected(number.error());

  ReadSolid read;
  const auto used =
      std::count_if(number->begin(), number->end(), [](int n) { return n != kUnused; });
  read.mesh.rest_m.resize(3, used);
  for (std::size_t n = 0; n < number->size(); ++n) {
    if ((*number)[n] == kUnused) continue;
    read.mesh.rest_m.col((*number)[n]) = metres_per_unit * msh->nodes[n].place;
    read.node_tag.push_back(msh->nodes[n].tag);
  }
  for (const Element& element : msh->elements) {
    std::array<int, 8> node{};
    for (std::size_t k = 0; k < element.count; ++k)
      node[k] = (*number)[static_cast<std::size_t>(find(msh->nodes, element.tags[k]))];
    if (element.count == 8)
      read.mesh.hexahedra.push_back(node);
    else
      read.mesh.tetrahedra.push_back({node[0], node[1], node[2], node[3]});
  }
  if (auto checked = check(read.mesh); !checked) return tl::unexpected(checked.error());
  return read;
}

}  // namespace tenter::mechanics
