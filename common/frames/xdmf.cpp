// SPDX-License-Identifier: Apache-2.0
// Xdmf version 3, with the forms that version 2 reads too: a temporal collection, and one slab of
// the HDF5 lists per frame. Numbers stay in the HDF5 file.
#include <filesystem>
#include <optional>

#include "common/base/atomic_write.h"
#include "common/frames/frames_file.h"
#include "common/h5/reader.h"

namespace tenter::frames {

namespace {

using h5::H5Reader;
using Shape = std::vector<std::uint64_t>;

struct CellKind {
  const char* kind;
  const char* topology;
};
constexpr CellKind kCells[] = {
    {"triangle", "Triangle"}, {"tetrahedron", "Tetrahedron"}, {"hexahedron", "Hexahedron"}};

struct Strain {
  std::string path, term;
  Shape shape;
};

/// Cells of one kind and the strains on them.
struct Cells {
  std::string path;
  const char* topology = "";
  Shape shape;
  std::vector<Strain> strains;
};

struct Contents {
  std::string file;  ///< name without folder, as XML text
  Shape position;
  std::vector<Cells> cells;
};

std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string words(std::initializer_list<std::uint64_t> values) {
  std::string text;
  for (const std::uint64_t value : values)
    text += (text.empty() ? "" : " ") + std::to_string(value);
  return text;
}

std::string whole_item(const Contents& contents, const Cells& cells, const std::string& indent) {
  return indent + "<DataItem Dimensions=\"" + words({cells.shape[0], cells.shape[1]}) +
         "\" NumberType=\"Int\" Precision=\"4\" Format=\"HDF\">" + contents.file + ":" +
         xml(cells.path) + "</DataItem>\n";
}

/// One frame of a list [frame][count][width]; from `first` on, `taken` of the last index.
std::string slab_item(const Contents& contents, const std::string& path, const Shape& shape,
                      std::uint64_t frame, std::uint64_t first, std::uint64_t taken,
                      const std::string& indent) {
  return indent + "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" + words({shape[1], taken}) +
         "\" Type=\"HyperSlab\">\n" + indent +
         "  <DataItem Dimensions=\"3 3\" NumberType=\"Int\" Format=\"XML\">" +
         words({frame, 0, first, 1, 1, 1, 1, shape[1], taken}) + "</DataItem>\n" + indent +
         "  <DataItem Dimensions=\"" + words({shape[0], shape[1], shape[2]}) +
         "\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">" + contents.file + ":" +
         xml(path) + "</DataItem>\n" + indent + "</DataItem>\n";
}

std::string grid(const Contents& contents, const Cells& cells, std::uint64_t frame,
                 const std::string& name, bool has_time, const std::string& indent) {
  const std::string in = indent + "  ";
  std::string text = indent + "<Grid Name=\"" + name + "\" GridType=\"Uniform\">\n";
  if (has_time) text += in + "<Time Value=\"" + std::to_string(frame) + "\"/>\n";
  text += in + "<Topology TopologyType=\"" + cells.topology + "\" NumberOfElements=\"" +
          std::to_string(cells.shape[0]) + "\">\n" + whole_item(contents, cells, in + "  ") + in +
          "</Topology>\n";
  text +=
      in + "<Geometry GeometryType=\"XYZ\">\n" +
      slab_item(contents, "/entry/positions/position", contents.position, frame, 0, 3, in + "  ") +
      in + "</Geometry>\n";
  for (const Strain& strain : cells.strains)
    for (std::uint64_t i = 0; i < strain.shape[2]; ++i) {
      const std::string number = strain.shape[2] > 1 ? "." + std::to_string(i + 1) : "";
      text += in + "<Attribute Name=\"" + xml(strain.term) + number +
              "\" AttributeType=\"Scalar\" Center=\"Cell\">\n" +
              slab_item(contents, strain.path, strain.shape, frame, i, 1, in + "  ") + in +
              "</Attribute>\n";
    }
  return text + indent + "</Grid>\n";
}

Expected<std::optional<Cells>> cells_of(const H5Reader& file, const CellKind& kind) {
  Cells cells;
  cells.path = std::string("/entry/mesh/") + kind.kind;
  cells.topology = kind.topology;
  const auto there = file.has(cells.path);
  if (!there) return tl::unexpected(there.error());
  if (!*there) return std::nullopt;
  const auto shape = file.shape(cells.path);
  if (!shape) return tl::unexpected(shape.error());
  if (shape->size() != 2) return file.complaint(cells.path, "must have two dimensions");
  cells.shape = *shape;
  return cells;
}

Expected<void> add_strains(const H5Reader& file, const Contents& contents, Cells& cells,
                           const std::string& kind) {
  const auto groups = file.members("/entry/strains");
  if (!groups) return tl::unexpected(groups.error());
  for (const std::string& name : *groups) {
    const std::string group = "/entry/strains/" + name;
    const auto on = file.text_attribute(group, "element_kind");
    if (!on) return tl::unexpected(on.error());
    if (*on != kind) continue;
    const auto term = file.text_attribute(group, "term");
    if (!term) return tl::unexpected(term.error());
    Strain strain{group + "/strain", *term, {}};
    const auto shape = file.shape(strain.path);
    if (!shape) return tl::unexpected(shape.error());
    if (shape->size() != 3 || (*shape)[0] != contents.position[0] || (*shape)[1] != cells.shape[0])
      return file.complaint(strain.path, "does not fit the frames and elements");
    strain.shape = *shape;
    cells.strains.push_back(std::move(strain));
  }
  return {};
}

Expected<Contents> contents_of(const std::string& path) {
  const auto file = H5Reader::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto schema = file->text_attribute("/", "schema");
  if (!schema) return tl::unexpected(schema.error());
  if (*schema != kSchema)
    return file->complaint("/", "has schema \"" + *schema + "\", not \"" + kSchema + "\"");
  Contents contents;
  contents.file = xml(std::filesystem::path(path).filename().string());
  const auto position = file->shape("/entry/positions/position");
  if (!position) return tl::unexpected(position.error());
  if (position->size() != 3 || (*position)[2] != 3)
    return file->complaint("/entry/positions/position", "must have frames, nodes and 3 components");
  contents.position = *position;
  for (const CellKind& kind : kCells) {
    auto cells = cells_of(*file, kind);
    if (!cells) return tl::unexpected(cells.error());
    if (!*cells) continue;
    if (auto ok = add_strains(*file, contents, **cells, kind.kind); !ok)
      return tl::unexpected(ok.error());
    contents.cells.push_back(std::move(**cells));
  }
  if (contents.cells.empty()) return file->complaint("/entry/mesh", "has no cells");
  return contents;
}

}  // namespace

Expected<std::string> xdmf_of(const std::string& frames_path) {
  const auto contents = contents_of(frames_path);
  if (!contents) return tl::unexpected(contents.error());
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (std::uint64_t frame = 0; frame < contents->position[0]; ++frame) {
    const std::string name = "frame_" + std::to_string(frame);
    if (contents->cells.size() == 1) {
      text += grid(*contents, contents->cells[0], frame, name, true, "      ");
      continue;
    }
    text += "      <Grid Name=\"" + name +
            "\" GridType=\"Collection\" CollectionType=\"Spatial\">\n        <Time Value=\"" +
            std::to_string(frame) + "\"/>\n";
    for (const Cells& cells : contents->cells)
      text += grid(*contents, cells, frame, cells.topology, false, "        ");
    text += "      </Grid>\n";
  }
  return text + "    </Grid>\n  </Domain>\n</Xdmf>\n";
}

Expected<void> write_xdmf(const std::string& frames_path, const std::string& xdmf_path) {
  const auto text = xdmf_of(frames_path);
  if (!text) return tl::unexpected(text.error());
  return write_atomically(xdmf_path, text->data(), text->size());
}

}  // namespace tenter::frames
