// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements follow, how many, of which properties.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/mesh_text/words.h"

namespace tenter::mesh_text {

enum class PlyFormat { ascii, little_endian, big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool list = false;
  PlyType count_type = PlyType::uint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
};

/// Reads up to and with end_header, from where the data begins at lines.position(). bad_input with
/// the line.
Expected<PlyHeader> read_ply_header(Lines& lines);

}  // namespace tenter::mesh_text
