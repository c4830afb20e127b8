// SPDX-License-Identifier: Apache-2.0
// The words that captures use on disk, in descriptions and in tables, both ways.
//
//   to_word(Branch::load) == "load";  from_word<Branch>("load") == Branch::load;  words<Branch>()
//   lists all.
//
// To add a word: its enumerator in capture.h and its row in vocabulary.cpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/capture/capture.h"

namespace tenter::capture {

/// Word of an enumerator of Quantity, Branch, AxisState::Role, ::Source, ::Reference,
/// Protocol::History.
template <class Enum>
std::string to_word(Enum value);

/// The enumerator, or nothing where the word is unknown.
template <class Enum>
std::optional<Enum> from_word(const std::string& word);

/// All words of an enumeration, for messages: "load, unload, hold, other".
template <class Enum>
std::string words();

/// SI unit of a quantity as captures store it: "N", "N/m", "Pa", "m" or "1"; "" for
/// Quantity::other.
std::string unit_of(Quantity quantity);

/// True for force, membrane_stress and stress.
bool is_force_like(Quantity quantity);

}  // namespace tenter::capture
