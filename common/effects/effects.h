// SPDX-License-Identifier: Apache-2.0
// Which causes of misfit are known, and what does each look like?
//
// The words only: what an effect computes is its file in server/diagnosis. Rows are in the order of
// the design's table: material, sensors and rig, numbers.
//
//   for (const effects::Row& row : effects::catalogue()) print(row.id, row.words);
//   if (const effects::Row* row = effects::find("viscosity")) print(row->protocol.words);
//
// Constant tables; from any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tenter::effects {

/// What is to blame: what travels with the specimen is material, what stays with the channel is
/// sensor, what moves with mesh, tolerance or start is numerical.
enum class Kind { material, sensor, numerical };

/// One step of a protocol, as the rig's scripts name it.
struct Phase {
  std::string kind;  ///< "ramp", "hold", "cycle", "repeat", "blank", "weight"
  std::string words;
};

struct Protocol {
  std::string name;
  std::string words;
  std::vector<Phase> phases;
};

struct Row {
  std::string id;
  Kind kind = Kind::material;
  std::string words;      ///< completes "The specimen shows ..." or "The channel shows ..."
  std::string signature;  ///< what it leaves in the residuals
  std::string extension;  ///< what is added to a model for it, or what is checked instead
  std::vector<std::string> mistaken_for;  ///< ids
  Protocol protocol;  ///< shows it, and splits it from those that it is mistaken for
};

const std::vector<Row>& catalogue();

/// nullptr where there is no such id.
const Row* find(std::string_view id);

/// "material", "sensor", "numerical".
std::string_view kind_name(Kind kind);

/// The three parts of the catalogue.
std::vector<Row> material_rows();
std::vector<Row> sensor_rows();
std::vector<Row> numerical_rows();

}  // namespace tenter::effects
