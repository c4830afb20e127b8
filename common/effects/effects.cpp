// SPDX-License-Identifier: Apache-2.0
#include "common/effects/effects.h"

namespace tenter::effects {

const std::vector<Row>& catalogue() {
  static const std::vector<Row> rows = [] {
    std::vector<Row> all = material_rows();
    for (Row& row : sensor_rows()) all.push_back(std::move(row));
    for (Row& row : numerical_rows()) all.push_back(std::move(row));
    return all;
  }();
  return rows;
}

const Row* find(std::string_view id) {
  for (const Row& row : catalogue())
    if (row.id == id) return &row;
  return nullptr;
}

std::string_view kind_name(Kind kind) {
  switch (kind) {
    case Kind::material:
      return "material";
    case Kind::sensor:
      return "sensor";
    case Kind::numerical:
      return "numerical";
  }
  return "";
}

}  // namespace tenter::effects
