// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/vertex_residuals.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "common/h5/guard.h"
#include "common/h5/reader.h"
#include "common/report/residual_file.h"

namespace tenter::report {

namespace {

struct Positions {
  const char* name;
  std::vector<double> VertexResiduals::*values;
};
constexpr Positions kPositions[] = {{"measured", &VertexResiduals::measured_m},
                                    {"predicted_start", &VertexResiduals::start_m},
                                    {"predicted_fitted", &VertexResiduals::fitted_m}};

std::string block_group(std::size_t i) {
  std::array<char, 40> name{};
  std::snprintf(name.data(), name.size(), "/entry/vertices_%04zu", i);
  return name.data();
}

/// Name of the first member whose size does not fit, or "".
std::string odd_member(const VertexResiduals& block) {
  if (block.material_m.size() != 2 * block.vertex.size()) return "material";
  if (block.sigma_m.size() != block.vertex.size()) return "sigma";
  for (const Positions& positions : kPositions)
    if ((block.*positions.values).size() != 3 * block.frame.size() * block.vertex.size())
      return positions.name;
  return "";
}

Expected<VertexResiduals> read_block(const h5::H5Reader& file, const std::string& group) {
  VertexResiduals block;
  for (const auto& [name, words] :
       {std::pair{"capture_id", &block.capture_id}, {"capture_title", &block.capture_title}}) {
    Expected<std::string> value = file.text_attribute(group, name);
    if (!value) return tl::unexpected(value.error());
    *words = std::move(*value);
  }
  for (const auto& [name, list] : {std::pair{"frame", &block.frame}, {"vertex", &block.vertex}}) {
    Expected<std::vector<int>> values = file.ints(group + "/" + name);
    if (!values) return tl::unexpected(values.error());
    *list = std::move(*values);
  }
  const auto read_table = [&](const std::string& name, std::vector<double>& into,
                              const std::vector<std::uint64_t>& shape) -> Expected<void> {
    Expected<h5::H5Reader::Table> table = file.table(group + "/" + name);
    if (!table) return tl::unexpected(table.error());
    if (table->shape != shape)
      return file.complaint(group + "/" + name, "has a shape that does not fit frame and vertex");
    into = std::move(table->values);
    return {};
  };
  const std::uint64_t frames = block.frame.size();
  const std::uint64_t vertices = block.vertex.size();
  if (auto ok = read_table("material", block.material_m, {vertices, 2}); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = read_table("sigma", block.sigma_m, {vertices}); !ok)
    return tl::unexpected(ok.error());
  for (const Positions& positions : kPositions)
    if (auto ok = read_table(positions.name, block.*positions.values, {frames, vertices, 3}); !ok)
      return tl::unexpected(ok.error());
  return block;
}

std::vector<std::size_t> kept(const std::vector<int>& numbers, std::optional<int> first,
                              std::optional<int> last) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if ((!first || numbers[i] >= *first) && (!last || numbers[i] <= *last)) places.push_back(i);
  return places;
}

VertexResiduals filtered(const VertexResiduals& block, const VertexFilter& filter) {
  const auto frames = kept(block.frame, filter.first_frame, filter.last_frame);
  const auto vertices = kept(block.vertex, filter.first_vertex, filter.last_vertex);
  VertexResiduals part;
  part.capture_id = block.capture_id;
  part.capture_title = block.capture_title;
  for (const std::size_t f : frames) part.frame.push_back(block.frame[f]);
  for (const std::size_t v : vertices) {
    part.vertex.push_back(block.vertex[v]);
    part.sigma_m.push_back(block.sigma_m[v]);
    for (std::size_t c = 0; c < 2; ++c) part.material_m.push_back(block.material_m[2 * v + c]);
  }
  for (const Positions& positions : kPositions)
    for (const std::size_t f : frames)
      for (const std::size_t v : vertices)
        for (std::size_t c = 0; c < 3; ++c)
          (part.*positions.values).push_back((block.*positions.values)[block.at(f, v) + c]);
  return part;
}

}  // namespace

double VertexResiduals::residual_m(std::size_t frame_index, std::size_t vertex_index) const {
  const std::size_t first = at(frame_index, vertex_index);
  double sum = 0.0;
  bool is_measured = false;
  for (std::size_t c = first; c < first + 3; ++c) {
    const double difference = measured_m[c] - fitted_m[c];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    is_measured = true;
  }
  return is_measured ? std::sqrt(sum) : std::nan("");
}

Expected<void> write_vertex_blocks(h5::H5Writer& file, const std::vector<VertexResiduals>& blocks) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const VertexResiduals& block = blocks[i];
    if (const std::string odd = odd_member(block); !odd.empty())
      return fail(ErrorKind::internal, "vertex residuals of capture " + block.capture_id + ": " +
                                           odd + " does not fit frame and vertex.");
    const std::string group = block_group(i);
    const std::size_t frames = block.frame.size();
    const std::size_t vertices = block.vertex.size();
    file.group(group, "NXdata");
    file.attribute(group, "signal", std::string("residual"));
    file.attribute(group, "axes", std::vector<std::string>{"frame", "vertex"});
    file.attribute(group, "capture_id", block.capture_id);
    file.attribute(group, "capture_title", block.capture_title);
    file.array(group + "/frame", block.frame);
    file.array(group + "/vertex", block.vertex);
    file.array(group + "/material", block.material_m, {vertices, 2}, "m");
    file.array(group + "/sigma", block.sigma_m, "m");
    std::vector<double> lengths;
    for (std::size_t f = 0; f < frames; ++f)
      for (std::size_t v = 0; v < vertices; ++v) lengths.push_back(block.residual_m(f, v));
    file.array(group + "/residual", lengths, {frames, vertices}, "m");
    for (const Positions& positions : kPositions)
      file.array(group + "/" + positions.name, block.*positions.values, {frames, vertices, 3}, "m");
  }
  return {};
}

Expected<std::vector<VertexResiduals>> read_vertex_residuals(const std::string& path,
                                                             const VertexFilter& filter) {
  const Expected<h5::H5Reader> file = h5::H5Reader::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto ok = check_residual_file(*file); !ok) return tl::unexpected(ok.error());
  const Expected<std::vector<std::string>> members = file->members("/entry");
  if (!members) return tl::unexpected(members.error());
  std::vector<VertexResiduals> blocks;
  for (const std::string& name : *members) {
    if (!name.starts_with("vertices_")) continue;
    const Expected<VertexResiduals> block = read_block(*file, "/entry/" + name);
    if (!block) return tl::unexpected(block.error());
    if (!names_capture(filter.capture, block->capture_id, block->capture_title)) continue;
    VertexResiduals part = filtered(*block, filter);
    if (!part.frame.empty() && !part.vertex.empty()) blocks.push_back(std::move(part));
  }
  return blocks;
}

Expected<std::vector<VertexResiduals>> read_vertex_residuals_guarded(const std::string& path,
                                                                     const VertexFilter& filter) {
  const Expected<void> safe = h5::run_guarded(path, [&]() -> Expected<void> {
    const auto blocks = read_vertex_residuals(path);
    if (!blocks) return tl::unexpected(blocks.error());
    return {};
  });
  if (!safe) return tl::unexpected(safe.error());
  return read_vertex_residuals(path, filter);
}

}  // namespace tenter::report
