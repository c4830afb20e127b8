// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet_import/sheet_import.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>

#include "common/base/not_a_number.h"
#include "common/base/text_file.h"
#include "common/capture/csv/csv_import_table.h"
#include "common/capture/sheet_import/sheet_description.h"
#include "common/capture/sheet_import/sheet_rest.h"
#include "common/capture/sheet_import/sheet_tables.h"
#include "common/capture/sheet_import/sheet_tracks.h"
#include "common/capture/validate.h"
#include "common/mesh_text/mesh_text.h"

namespace tenter::capture {

namespace {

constexpr std::size_t kMaxDescriptionBytes = 16000000;
constexpr double kFlatness = 1e-5;  // of its extent

/// The import of one sheet, step by step; each step fills one part of the capture.
class SheetImport {
 public:
  SheetImport(const SheetDescription& description, const std::string& json_path,
              const std::string& csv_path)
      : description_(description), folder_(json_path, csv_path) {}

  Expected<Capture> run() {
    if (auto ok = read_frames(); !ok) return tl::unexpected(ok.error());
    capture_.sheet = description_.head;
    if (auto ok = read_mesh(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_positions(); !ok) return tl::unexpected(ok.error());
    SheetTracks tracks(description_, folder_, frames_, capture_);
    if (auto ok = tracks.read(vertex_of_); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_rest_state(); !ok) return tl::unexpected(ok.error());
    if (!has_branches_) detect_branches_of_runs(capture_);
    if (auto ok = name_origin(); !ok) return tl::unexpected(ok.error());
    return std::move(capture_);
  }

 private:
  Sheet& sheet() { return *capture_.sheet; }

  Expected<void> read_frames() {
    const Description& frames = description_.frames;
    const auto open = folder_.open(description_.frames_file, frames.csv,
                                   description_.are_frames_given ? "frames" : "positions");
    if (!open) return tl::unexpected(open.error());
    Expected<ImportedTable> imported =
        import_table((*open)->table, frames, (*open)->name, folder_.json());
    if (!imported) return tl::unexpected(imported.error());
    capture_ = std::move(imported->capture);
    const ColumnDescription* run = frames.find(&ColumnDescription::is_run);
    frames_.has_runs = run != nullptr;
    frames_.run_count = capture_.runs.size();
    for (std::size_t f = 0; f < imported->rows.size(); ++f) {
      const CsvTable& table = (*open)->table;
      frames_.add(run ? table.cell(imported->rows[f], table.find(run->csv)) : "", capture_.frame[f],
                  f);
    }
    has_branches_ = frames.branch || frames.find(&ColumnDescription::is_branch);
    return {};
  }

  // ---- places in the material

  Expected<void> add_vertex(const std::string& name, const Vec2& material, double sigma,
                            const std::string& where) {
    if (!vertex_of_.emplace(name, static_cast<int>(sheet().material_m.size())).second)
      return bad_input(where + ": vertex \"" + name + "\" appears twice.");
    sheet().material_m.push_back(material);
    names_.push_back(name);
    if (!std::isnan(sigma)) sheet().sigma_per_vertex_m.push_back(sigma);
    return {};
  }

  Expected<void> read_mesh() {
    for (const PointSpec& point : description_.points)
      if (auto ok = add_vertex(point.name, point.material_m.value_or(Vec2{}), kNaN, folder_.json());
          !ok)
        return ok;
    if (!description_.mesh) return {};
    const MeshSpec& mesh = *description_.mesh;
    if (!mesh.file.empty()) return read_mesh_file(mesh);
    if (auto ok = read_vertices(mesh); !ok) return ok;
    return mesh.triangles ? read_triangles(*mesh.triangles) : Expected<void>();
  }

  /// Texture coordinates, or the places of a sheet that lies in a plane of the file's x and y.
  Expected<void> read_mesh_file(const MeshSpec& mesh) {
    const std::string path = folder_.path_of(mesh.file);
    const Expected<std::string> bytes = read_text_file(path, kMaxCsvBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    const auto read = mesh_text::read_surface_text(*bytes, mesh.metres_per_unit);
    if (!read) return bad_input(path + ": " + read.error().message + ".");
    Eigen::Matrix2Xd material = read->texture * mesh.metres_per_texture_unit;
    if (material.cols() == 0) {
      const Eigen::Vector3d size =
          read->positions_m.rowwise().maxCoeff() - read->positions_m.rowwise().minCoeff();
      if (!(size.z() <= kFlatness * size.norm()))
        return bad_input(path +
                         ": has no texture coordinates, and does not lie in a plane of x and y "
                         "either, so its places in the material are not known.");
      material = read->positions_m.topRows<2>();
    }
    for (Eigen::Index k = 0; k < material.cols(); ++k)
      if (auto ok = add_vertex(std::to_string(mesh.first_vertex + k),
                               {material(0, k), material(1, k)}, kNaN, path);
          !ok)
        return ok;
    sheet().triangles = read->triangles;
    return {};
  }

  Expected<void> read_vertices(const MeshSpec& mesh) {
    const TableSpec& spec = *mesh.vertices;
    const Expected<SheetTable> table = SheetTable::make(folder_, spec);
    if (!table) return tl::unexpected(table.error());
    int next = mesh.first_vertex;
    for (const std::size_t row : table->rows()) {
      const Expected<double> u = table->number(row, table->column("u"), spec.to_si);
      if (!u) return tl::unexpected(u.error());
      const Expected<double> v = table->number(row, table->column("v"), spec.to_si);
      if (!v) return tl::unexpected(v.error());
      double sigma = kNaN;
      if (spec.has("sigma")) {
        const Expected<double> given = table->number(row, table->column("sigma"), {});
        if (!given) return tl::unexpected(given.error());
        sigma = spec.to_si.apply_to_difference(*given);
      }
      const std::string name =
          spec.has("vertex") ? table->cell(row, table->column("vertex")) : std::to_string(next++);
      if (auto ok = add_vertex(name, {*u, *v}, sigma, table->line_of(row)); !ok) return ok;
    }
    return {};
  }

  Expected<void> read_triangles(const TableSpec& spec) {
    const Expected<SheetTable> table = SheetTable::make(folder_, spec);
    if (!table) return tl::unexpected(table.error());
    for (const std::size_t row : table->rows()) {
      std::array<int, 3> corners{};
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t column = table->column(std::string(1, static_cast<char>('a' + c)));
        const auto vertex = vertex_of_.find(table->cell(row, column));
        if (vertex == vertex_of_.end())
          return table->at(row, column,
                           "\"" + table->cell(row, column).substr(0, 40) + "\" is no vertex");
        corners[c] = vertex->second;
      }
      sheet().triangles.push_back(corners);
    }
    return {};
  }

  // ---- positions

  /// One coordinate of a vertex: a column with the place, or with the displacement from the
  /// material's place (u, v, 0).
  struct Coordinate {
    std::size_t column = 0;
    bool is_displacement = false;
  };

  Expected<std::vector<Coordinate>> coordinates(const SheetTable& table,
                                                const std::map<std::string, std::string>& columns) {
    std::vector<Coordinate> found;
    for (const char* name : {"x", "y", "z"}) {
      const auto place = columns.find(name);
      const auto displacement = columns.find(std::string("d") + name);
      if (place != columns.end() && displacement != columns.end())
        return bad_input(folder_.json() + ": positions give both " + name + " and d" + name + ".");
      if (place == columns.end() && displacement == columns.end()) {
        if (*name != 'z')
          return bad_input(folder_.json() + ": positions have no column for " + name + " or d" +
                           name + ".");
        continue;
      }
      const std::string& header = place != columns.end() ? place->second : displacement->second;
      if (auto ok = table.require_column(header, "positions"); !ok)
        return tl::unexpected(ok.error());
      found.push_back({table.column_of(header), place == columns.end()});
    }
    if (!coordinates_) coordinates_ = found.size();
    if (*coordinates_ != found.size())
      return bad_input(folder_.json() + ": some points have a height and some have none.");
    return found;
  }

  Expected<void> read_positions() {
    const TableSpec& spec = description_.positions;
    const Expected<SheetTable> table = SheetTable::make(folder_, spec);
    if (!table) return tl::unexpected(table.error());
    if (auto ok = description_.points.empty() ? read_long(*table) : read_wide(*table); !ok)
      return ok;
    if (description_.material_from_first_frame)
      for (std::size_t k = 0; k < sheet().vertex_count(); ++k)
        for (std::size_t c = 0; c < 2; ++c) {
          sheet().material_m[k][c] = sheet().position_m[sheet().at(0, k) + c];
          if (std::isnan(sheet().material_m[k][c]))
            return bad_input(table->name() + ": vertex \"" + names_[k] +
                             "\" is not seen in the first frame, which gives its place in the "
                             "material.");
        }
    if (are_vertices_named()) sheet().vertex_name = names_;
    return {};
  }

  Expected<void> read_rest_state() {
    if (!description_.rest) return {};
    const RestSpec& rest = *description_.rest;
    if (rest.slack_below_m > 0.0) sheet().slack = SlackRule{rest.clips, rest.slack_below_m};
    if (!description_.material_from_rest) return {};
    auto places = places_at_rest(capture_, rest);
    if (!places) return bad_input(folder_.json() + ": " + places.error().message + ".");
    sheet().material_m = std::move(*places);
    return {};
  }

  /// Plain numbers from 0 are no names, unless a table of vertices gives them as such.
  bool are_vertices_named() const {
    if (description_.mesh)
      return description_.mesh->vertices && description_.mesh->vertices->has("vertex");
    for (std::size_t k = 0; k < names_.size(); ++k)
      if (names_[k] != std::to_string(k)) return true;
    return false;
  }

  /// Vertices in the order of the rows, where no mesh names them.
  Expected<void> find_vertices(const SheetTable& table) {
    const TableSpec& spec = description_.positions;
    const std::size_t name = table.column("vertex");
    for (const std::size_t row : table.rows()) {
      if (vertex_of_.count(table.cell(row, name)) != 0) continue;
      Vec2 material{};
      if (table.has("u") && table.has("v")) {
        const Expected<double> u = table.number(row, table.column("u"), spec.to_si);
        if (!u) return tl::unexpected(u.error());
        const Expected<double> v = table.number(row, table.column("v"), spec.to_si);
        if (!v) return tl::unexpected(v.error());
        material = {*u, *v};
      }
      if (auto ok = add_vertex(table.cell(row, name), material, kNaN, table.line_of(row)); !ok)
        return ok;
    }
    return {};
  }

  Expected<double> coordinate(const SheetTable& table, std::size_t row, const Coordinate& from,
                              int vertex, std::size_t c) {
    const TableSpec& spec = description_.positions;
    Expected<double> value = table.number(row, from.column, spec.to_si, spec.may_be_missing);
    if (!value || !from.is_displacement) return value;
    return *value + (c < 2 ? sheet().material_m[static_cast<std::size_t>(vertex)][c] : 0.0);
  }

  void make_room() {
    sheet().coordinates = static_cast<int>(*coordinates_);
    sheet().position_m.assign(capture_.frame_count() * sheet().vertex_count() * *coordinates_,
                              kNaN);
  }

  /// One row a vertex and frame.
  Expected<void> read_long(const SheetTable& table) {
    const TableSpec& spec = description_.positions;
    if (!description_.mesh)
      if (auto ok = find_vertices(table); !ok) return ok;
    const auto columns = coordinates(table, spec.columns);
    if (!columns) return tl::unexpected(columns.error());
    make_room();
    const std::size_t name = table.column("vertex");
    std::vector<bool> seen(capture_.frame_count() * sheet().vertex_count(), false);
    for (const std::size_t row : table.rows()) {
      const auto frame = table.frame(row, frames_);
      if (!frame) return tl::unexpected(frame.error());
      if (!*frame) continue;
      const auto vertex = vertex_of_.find(table.cell(row, name));
      if (vertex == vertex_of_.end())
        return table.at(row, name,
                        "\"" + table.cell(row, name).substr(0, 40) + "\" is no vertex of the mesh");
      const std::size_t place =
          **frame * sheet().vertex_count() + static_cast<std::size_t>(vertex->second);
      if (seen[place]) return table.at(row, name, "this vertex has been given for this frame");
      seen[place] = true;
      for (std::size_t c = 0; c < columns->size(); ++c) {
        const Expected<double> value = coordinate(table, row, (*columns)[c], vertex->second, c);
        if (!value) return tl::unexpected(value.error());
        sheet().position_m[place * *coordinates_ + c] = *value;
      }
    }
    return complain_of_gaps(table, seen);
  }

  /// One row a frame, with columns for every point.
  Expected<void> read_wide(const SheetTable& table) {
    std::vector<std::vector<Coordinate>> columns;
    for (const PointSpec& point : description_.points) {
      auto of_point = coordinates(table, point.columns);
      if (!of_point) return tl::unexpected(of_point.error());
      columns.push_back(std::move(*of_point));
    }
    make_room();
    std::vector<bool> seen(capture_.frame_count() * sheet().vertex_count(), false);
    for (const std::size_t row : table.rows()) {
      const auto frame = table.frame(row, frames_);
      if (!frame) return tl::unexpected(frame.error());
      if (!*frame) continue;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const std::size_t place = **frame * sheet().vertex_count() + k;
        if (seen[place])
          return table.at(row, table.column("frame"), "this frame has been given before");
        seen[place] = true;
        for (std::size_t c = 0; c < columns[k].size(); ++c) {
          const Expected<double> value =
              coordinate(table, row, columns[k][c], static_cast<int>(k), c);
          if (!value) return tl::unexpected(value.error());
          sheet().position_m[place * *coordinates_ + c] = *value;
        }
      }
    }
    return complain_of_gaps(table, seen);
  }

  Expected<void> complain_of_gaps(const SheetTable& table, const std::vector<bool>& seen) const {
    if (description_.positions.may_be_missing) return {};
    const auto gap = std::find(seen.begin(), seen.end(), false);
    if (gap == seen.end()) return {};
    const auto place = static_cast<std::size_t>(gap - seen.begin());
    return bad_input(table.name() + ": has no row for vertex \"" + names_[place % names_.size()] +
                     "\" in frame " + std::to_string(capture_.frame[place / names_.size()]) +
                     ", and " + folder_.json() + " does not declare missing positions.");
  }

  Expected<void> name_origin() {
    if (description_.frames.origin_given) return {};
    const TableSpec& spec = description_.positions;
    const auto open = folder_.open(spec.file, spec.csv, spec.key);
    if (!open) return tl::unexpected(open.error());
    Provenance& provenance = capture_.provenance;
    provenance.imported_from = std::filesystem::path((*open)->name).filename().string();
    provenance.imported_sha256 = (*open)->sha256;
    return {};
  }

  const SheetDescription& description_;
  TableFolder folder_;
  FrameIndex frames_;
  std::unordered_map<std::string, int> vertex_of_;
  std::vector<std::string> names_;
  std::optional<std::size_t> coordinates_;
  bool has_branches_ = false;
  Capture capture_;
};

}  // namespace

Expected<Capture> import_sheet(const std::string& describe_path, const std::string& csv_path) {
  const Expected<std::string> text = read_text_file(describe_path, kMaxDescriptionBytes);
  if (!text) return tl::unexpected(text.error());
  const Expected<SheetDescription> description = parse_sheet_description(*text, describe_path);
  if (!description) return tl::unexpected(description.error());
  Expected<Capture> capture = SheetImport(*description, describe_path, csv_path).run();
  if (!capture) return capture;
  if (auto ok = validate(*capture); !ok)
    return fail(ok.error().kind, describe_path + ": " + ok.error().message + ".");
  return capture;
}

}  // namespace tenter::capture
