// SPDX-License-Identifier: Apache-2.0
#include "common/report/residual_file.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/h5/guard.h"
#include "common/h5/reader.h"
#include "common/h5/writer.h"

namespace tenter::report {

namespace {

constexpr const char* kSchema = "tenter.residuals";
constexpr std::int64_t kVersion = 1;
constexpr std::size_t kShortestId = 6;

struct IntColumn {
  const char* name;
  std::vector<int> ResidualTable::*values;
};
constexpr IntColumn kInts[] = {{"frame", &ResidualTable::frame},
                               {"run", &ResidualTable::run},
                               {"block", &ResidualTable::block},
                               {"branch", &ResidualTable::branch}};

/// `unit` nullptr: the table's unit.
struct RealColumn {
  const char* name;
  const char* unit;
  std::vector<double> ResidualTable::*values;
};
constexpr RealColumn kReals[] = {
    {"strain_x", "1", &ResidualTable::strain_x},
    {"strain_y", "1", &ResidualTable::strain_y},
    {"strain_xy", "1", &ResidualTable::strain_xy},
    {"measured", nullptr, &ResidualTable::measured},
    {"predicted_baseline", nullptr, &ResidualTable::predicted_baseline},
    {"predicted_extended", nullptr, &ResidualTable::predicted_extended},
    {"sigma", nullptr, &ResidualTable::sigma},
    {"weight", "1", &ResidualTable::weight}};

/// Columns that a table may lack.
struct OptionalColumn {
  const char* name;
  const char* unit;
  std::vector<double> ResidualTable::*values;
};
constexpr OptionalColumn kOptional[] = {{"time_s", "s", &ResidualTable::time_s},
                                        {"displacement_m", "m", &ResidualTable::displacement_m}};

std::string table_group(std::size_t i) {
  std::array<char, 40> name{};
  std::snprintf(name.data(), name.size(), "/entry/table_%04zu", i);
  return name.data();
}

/// Name of the first column whose length is not that of `frame`, or "".
std::string odd_column(const ResidualTable& table) {
  for (const IntColumn& column : kInts)
    if ((table.*column.values).size() != table.size()) return column.name;
  for (const RealColumn& column : kReals)
    if ((table.*column.values).size() != table.size()) return column.name;
  for (const OptionalColumn& column : kOptional)
    if (const auto& values = table.*column.values; !values.empty() && values.size() != table.size())
      return column.name;
  return "";
}

void write_table(h5::H5Writer& file, const std::string& group, const ResidualTable& table) {
  file.group(group, "NXdata");
  file.attribute(group, "signal", std::string("measured"));
  file.attribute(
      group, "axes",
      std::vector<std::string>{table.displacement_m.empty() ? "strain_x" : "displacement_m"});
  file.attribute(group, "capture_id", table.capture_id);
  file.attribute(group, "capture_title", table.capture_title);
  file.attribute(group, "channel", table.channel);
  file.attribute(group, "unit", table.unit);
  for (const IntColumn& column : kInts) file.array(group + "/" + column.name, table.*column.values);
  for (const RealColumn& column : kReals)
    file.array(group + "/" + column.name, table.*column.values,
               column.unit ? column.unit : table.unit);
  for (const OptionalColumn& column : kOptional)
    if (const auto& values = table.*column.values; !values.empty())
      file.array(group + "/" + column.name, values, column.unit);
}

/// The columns of one table; its four texts are there already.
Expected<void> read_columns(const h5::H5Reader& file, const std::string& group,
                            ResidualTable& table) {
  for (const IntColumn& column : kInts) {
    Expected<std::vector<int>> values = file.ints(group + "/" + column.name);
    if (!values) return tl::unexpected(values.error());
    table.*column.values = std::move(*values);
  }
  for (const RealColumn& column : kReals) {
    Expected<std::vector<double>> values = file.doubles(group + "/" + column.name);
    if (!values) return tl::unexpected(values.error());
    table.*column.values = std::move(*values);
  }
  for (const OptionalColumn& column : kOptional) {
    const Expected<bool> is_there = file.has(group + "/" + column.name);
    if (!is_there) return tl::unexpected(is_there.error());
    if (!*is_there) continue;
    Expected<std::vector<double>> values = file.doubles(group + "/" + column.name);
    if (!values) return tl::unexpected(values.error());
    table.*column.values = std::move(*values);
  }
  const std::string odd = odd_column(table);
  if (!odd.empty()) return file.complaint(group + "/" + odd, "has another length than frame");
  if (std::any_of(table.branch.begin(), table.branch.end(), [](int b) { return b < 0 || b > 3; }))
    return file.complaint(group + "/branch", "holds a number that is not 0 to 3");
  return {};
}

bool wanted(const ResidualTable& table, const ResidualFilter& filter) {
  if (!filter.channel.empty() && table.channel != filter.channel) return false;
  return names_capture(filter.capture, table.capture_id, table.capture_title);
}

template <class T>
void keep_rows(std::vector<T>& values, const std::vector<std::size_t>& rows) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < rows.size(); ++i) values[i] = values[rows[i]];
  values.resize(rows.size());
}

void keep_rows(ResidualTable& table, const ResidualFilter& filter) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < table.size(); ++i)
    if ((!filter.block || table.block[i] == *filter.block) &&
        (!filter.first_frame || table.frame[i] >= *filter.first_frame) &&
        (!filter.last_frame || table.frame[i] <= *filter.last_frame))
      rows.push_back(i);
  if (rows.size() == table.size()) return;
  for (const RealColumn& column : kReals) keep_rows(table.*column.values, rows);
  for (const OptionalColumn& column : kOptional) keep_rows(table.*column.values, rows);
  for (const IntColumn& column : kInts) keep_rows(table.*column.values, rows);
}

Expected<ResidualTable> read_head(const h5::H5Reader& file, const std::string& group) {
  ResidualTable table;
  for (const auto& [name, text] : {std::pair{"capture_id", &table.capture_id},
                                   {"capture_title", &table.capture_title},
                                   {"channel", &table.channel},
                                   {"unit", &table.unit}}) {
    Expected<std::string> value = file.text_attribute(group, name);
    if (!value) return tl::unexpected(value.error());
    *text = std::move(*value);
  }
  return table;
}

}  // namespace

Expected<void> check_residual_file(const h5::H5Reader& file) {
  const Expected<bool> named = file.has_attribute("/", "schema");
  if (!named) return tl::unexpected(named.error());
  if (!*named)
    return file.complaint("/", "has no attribute \"schema\"; it is not a residual file of Tenter");
  const Expected<std::string> schema = file.text_attribute("/", "schema");
  if (!schema) return tl::unexpected(schema.error());
  if (*schema != kSchema)
    return file.complaint("/", "has schema \"" + *schema + "\", not \"" + kSchema + "\"");
  const Expected<std::int64_t> version = file.integer_attribute("/", "version");
  if (!version) return tl::unexpected(version.error());
  if (*version != kVersion)
    return file.complaint(
        "/", "has version " + std::to_string(*version) + ", not " + std::to_string(kVersion));
  return {};
}

bool names_capture(const std::string& name, const std::string& id, const std::string& title) {
  return name.empty() || name == title || id == name ||
         (name.size() >= kShortestId && id.starts_with(name));
}

std::string branch_word(int branch) {
  constexpr std::array<const char*, 4> kWords = {"load", "unload", "hold", "other"};
  return branch >= 0 && branch < 4 ? kWords[static_cast<std::size_t>(branch)] : "other";
}

Expected<void> write_residuals(const std::vector<ResidualTable>& tables, const std::string& path,
                               const std::vector<VertexResiduals>& vertices) {
  h5::H5Writer file(path);
  file.group("/", "NXroot");
  file.attribute("/", "schema", std::string(kSchema));
  file.attribute("/", "version", kVersion);
  file.attribute("/", "default", std::string("entry"));
  file.group("/entry", "NXentry");
  if (!tables.empty()) file.attribute("/entry", "default", table_group(0).substr(7));
  if (auto done = write_vertex_blocks(file, vertices); !done)
    return fail(done.error().kind, path + ": " + done.error().message);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string odd = odd_column(tables[i]);
    if (!odd.empty())
      return fail(ErrorKind::internal, path + ": residuals of channel \"" + tables[i].channel +
                                           "\": column " + odd + " has another length than frame.");
    write_table(file, table_group(i), tables[i]);
  }
  return std::move(file).save();
}

Expected<std::vector<ResidualTable>> read_residuals(const std::string& path,
                                                    const ResidualFilter& filter) {
  const Expected<h5::H5Reader> file = h5::H5Reader::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto ok = check_residual_file(*file); !ok) return tl::unexpected(ok.error());
  const Expected<std::vector<std::string>> members = file->members("/entry");
  if (!members) return tl::unexpected(members.error());
  std::vector<ResidualTable> tables;
  for (const std::string& name : *members) {
    if (!name.starts_with("table_")) continue;
    const std::string group = "/entry/" + name;
    Expected<ResidualTable> table = read_head(*file, group);
    if (!table) return tl::unexpected(table.error());
    if (!wanted(*table, filter)) continue;
    if (auto ok = read_columns(*file, group, *table); !ok) return tl::unexpected(ok.error());
    keep_rows(*table, filter);
    if (table->size() > 0) tables.push_back(std::move(*table));
  }
  return tables;
}

Expected<std::vector<ResidualTable>> read_residuals_guarded(const std::string& path,
                                                            const ResidualFilter& filter) {
  const Expected<void> safe = h5::run_guarded(path, [&]() -> Expected<void> {
    const auto tables = read_residuals(path);
    if (!tables) return tl::unexpected(tables.error());
    return {};
  });
  if (!safe) return tl::unexpected(safe.error());
  return read_residuals(path, filter);
}

}  // namespace tenter::report
