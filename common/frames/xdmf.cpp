// SPDX-License-Identifier: Apache-2.0
// Only forms that ParaView's readers of version 2 and of version 3 both take: a temporal collection
// of grids, whose lists are whole datasets (version 3 reads no part of one). Numbers stay in the
// HDF5 file.
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
  std::string part;  ///< name within the folder of a frame
  std::string name;  ///< what a person reads
};

/// Cells of one kind and the strains on them.
struct Cells {
  std::string path;
  const char* topology = "";
  Shape shape;
  std::vector<Strain> strains;
};

struct Contents {
  std::string file;                  ///< name without folder, as XML text
  std::vector<std::string> folders;  ///< of the frames
  std::uint64_t nodes = 0;
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

std::string item(const Contents& contents, const std::string& path, const Shape& shape,
                 const char* type, const std::string& indent) {
  std::string sizes;
  for (const std::uint64_t length : shape)
    sizes += (sizes.empty() ? "" : " ") + std::to_string(length);
  return indent + "<DataItem Dimensions=\"" + sizes + "\" " + type + " Format=\"HDF\">" +
         contents.file + ":" + xml(path) + "</DataItem>\n";
}

constexpr const char* kDouble = "NumberType=\"Float\" Precision=\"8\"";
constexpr const char* kInt = "NumberType=\"Int\" Precision=\"4\"";

std::string grid(const Contents& contents, const Cells& cells, std::size_t frame,
                 const std::string& name, bool has_time, const std::string& indent) {
  const std::string in = indent + "  ";
  const std::string& folder = contents.folders[frame];
  std::string text = indent + "<Grid Name=\"" + name + "\" GridType=\"Uniform\">\n";
  if (has_time) text += in + "<Time Value=\"" + std::to_string(frame) + "\"/>\n";
  text += in + "<Topology TopologyType=\"" + cells.topology + "\" NumberOfElements=\"" +
          std::to_string(cells.shape[0]) + "\">\n" +
          item(contents, cells.path, cells.shape, kInt, in + "  ") + in + "</Topology>\n";
  text += in + "<Geometry GeometryType=\"XYZ\">\n" +
          item(contents, folder + "/position", {contents.nodes, 3}, kDouble, in + "  ") + in +
          "</Geometry>\n";
  for (const Strain& strain : cells.strains)
    text += in + "<Attribute Name=\"" + xml(strain.name) +
            "\" AttributeType=\"Scalar\" Center=\"Cell\">\n" +
            item(contents, folder + "/" + strain.part, {cells.shape[0]}, kDouble, in + "  ") + in +
            "</Attribute>\n";
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

/// Strains on cells of this kind: members "strain" or "strain_1", "strain_2", ... of their groups.
Expected<void> add_strains(const H5Reader& file, Cells& cells, const std::string& kind) {
  const auto groups = file.members("/entry/strains");
  if (!groups) return tl::unexpected(groups.error());
  for (const std::string& name : *groups) {
    const std::string group = "/entry/strains/" + name;
    const auto on = file.text_attribute(group, "element_kind");
    if (!on) return tl::unexpected(on.error());
    if (*on != kind) continue;
    const auto term = file.text_attribute(group, "term");
    if (!term) return tl::unexpected(term.error());
    const auto members = file.members(group);
    if (!members) return tl::unexpected(members.error());
    for (const std::string& member : *members)
      if (member.starts_with("strain")) {
        const std::string number = member.substr(std::string("strain").size());
        cells.strains.push_back({name + number, *term + number});
      }
  }
  return {};
}

/// Every frame has every list in the shape that the sidecar will say.
Expected<void> check_frames(const H5Reader& file, const Contents& contents) {
  const auto is = [&file](const std::string& path, const Shape& wanted) -> Expected<void> {
    const auto shape = file.shape(path);
    if (!shape) return tl::unexpected(shape.error());
    if (*shape != wanted) return file.complaint(path, "does not fit the mesh");
    return {};
  };
  for (const std::string& folder : contents.folders) {
    if (auto ok = is(folder + "/position", {contents.nodes, 3}); !ok) return ok;
    for (const Cells& cells : contents.cells)
      for (const Strain& strain : cells.strains)
        if (auto ok = is(folder + "/" + strain.part, {cells.shape[0]}); !ok) return ok;
  }
  return {};
}

Expected<Contents> contents_of(const std::string& path) {
  const auto file = H5Reader::open(path, {.members = kMostFrames});
  if (!file) return tl::unexpected(file.error());
  const auto schema = file->text_attribute("/", "schema");
  if (!schema) return tl::unexpected(schema.error());
  if (*schema != kSchema)
    return file->complaint("/", "has schema \"" + *schema + "\", not \"" + kSchema + "\"");
  Contents contents;
  contents.file = xml(std::filesystem::path(path).filename().string());
  const auto material = file->shape("/entry/mesh/material");
  if (!material) return tl::unexpected(material.error());
  contents.nodes = material->front();
  const auto folders = file->members("/entry/frames");
  if (!folders) return tl::unexpected(folders.error());
  for (const std::string& name : *folders) contents.folders.push_back("/entry/frames/" + name);
  for (const CellKind& kind : kCells) {
    auto cells = cells_of(*file, kind);
    if (!cells) return tl::unexpected(cells.error());
    if (!*cells) continue;
    if (auto ok = add_strains(*file, **cells, kind.kind); !ok) return tl::unexpected(ok.error());
    contents.cells.push_back(std::move(**cells));
  }
  if (contents.cells.empty()) return file->complaint("/entry/mesh", "has no cells");
  if (auto ok = check_frames(*file, contents); !ok) return tl::unexpected(ok.error());
  return contents;
}

}  // namespace

Expected<std::string> xdmf_of(const std::string& frames_path) {
  const auto contents = contents_of(frames_path);
  if (!contents) return tl::unexpected(contents.error());
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (std::size_t frame = 0; frame < contents->folders.size(); ++frame) {
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
