// SPDX-License-Identifier: Apache-2.0
#include "common/capture/vocabulary.h"

#include <span>
#include <string_view>

namespace tenter::capture {

namespace {

template <class Enum>
struct Row {
  Enum value;
  std::string_view word;
};

using Role = AxisState::Role;
using AxisSource = AxisState::Source;
using Reference = AxisState::Reference;
using History = Protocol::History;

constexpr Row<Quantity> kQuantities[] = {
    {Quantity::force, "force"},       {Quantity::membrane_stress, "membrane_stress"},
    {Quantity::stress, "stress"},     {Quantity::displacement, "displacement"},
    {Quantity::length, "length"},     {Quantity::stretch, "stretch"},
    {Quantity::strain, "strain"},     {Quantity::shear, "shear"},
    {Quantity::position, "position"}, {Quantity::other, "other"}};
constexpr Row<Branch> kBranches[] = {{Branch::load, "load"},
                                     {Branch::unload, "unload"},
                                     {Branch::hold, "hold"},
                                     {Branch::other, "other"}};
constexpr Row<Role> kRoles[] = {{Role::prescribed, "prescribed"},
                                {Role::observed, "observed"},
                                {Role::free, "free"},
                                {Role::fixed, "fixed"}};
constexpr Row<AxisSource> kSources[] = {
    {AxisSource::none, "none"}, {AxisSource::channel, "channel"}, {AxisSource::points, "points"}};
constexpr Row<Reference> kReferences[] = {
    {Reference::given, "given"},
    {Reference::first_frame_of_capture, "first_frame_of_capture"},
    {Reference::first_frame_of_run, "first_frame_of_run"}};
constexpr Row<History> kHistories[] = {{History::continues, "continues"},
                                       {History::virgin_each_run, "virgin_each_run"}};

template <class Enum>
std::span<const Row<Enum>> rows();
template <>
std::span<const Row<Quantity>> rows() {
  return kQuantities;
}
template <>
std::span<const Row<Branch>> rows() {
  return kBranches;
}
template <>
std::span<const Row<Role>> rows() {
  return kRoles;
}
template <>
std::span<const Row<AxisSource>> rows() {
  return kSources;
}
template <>
std::span<const Row<Reference>> rows() {
  return kReferences;
}
template <>
std::span<const Row<History>> rows() {
  return kHistories;
}

}  // namespace

template <class Enum>
std::string to_word(Enum value) {
  for (const Row<Enum>& row : rows<Enum>())
    if (row.value == value) return std::string(row.word);
  return "?";
}

template <class Enum>
std::optional<Enum> from_word(const std::string& word) {
  for (const Row<Enum>& row : rows<Enum>())
    if (row.word == word) return row.value;
  return std::nullopt;
}

template <class Enum>
std::string words() {
  std::string all;
  for (const Row<Enum>& row : rows<Enum>()) {
    if (!all.empty()) all += ", ";
    all += row.word;
  }
  return all;
}

#define TENTER_VOCABULARY(Enum)                                     \
  template std::string to_word<Enum>(Enum);                         \
  template std::optional<Enum> from_word<Enum>(const std::string&); \
  template std::string words<Enum>();
TENTER_VOCABULARY(Quantity)
TENTER_VOCABULARY(Branch)
TENTER_VOCABULARY(Role)
TENTER_VOCABULARY(AxisSource)
TENTER_VOCABULARY(Reference)
TENTER_VOCABULARY(History)
#undef TENTER_VOCABULARY

std::string unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::force:
      return "N";
    case Quantity::membrane_stress:
      return "N/m";
    case Quantity::stress:
      return "Pa";
    case Quantity::displacement:
    case Quantity::length:
    case Quantity::position:
      return "m";
    case Quantity::stretch:
    case Quantity::strain:
    case Quantity::shear:
      return "1";
    case Quantity::other:
      return "";
  }
  return "";
}

bool is_force_like(Quantity quantity) {
  return quantity == Quantity::force || quantity == Quantity::membrane_stress ||
         quantity == Quantity::stress;
}

}  // namespace tenter::capture
