// SPDX-License-Identifier: Apache-2.0
#include "common/model/usual_ranges.h"

namespace tenter::model {

namespace {

struct UsualRow {
  std::string_view strain;
  UsualRange usual;
};

constexpr UsualRange kStretch{6.0, 4500.0};
constexpr UsualRange kShear{0.0, 150.0};  // the smallest are below zero at large strains
constexpr UsualRange kBending{5e-7, 3e-5};
constexpr UsualRow kUsual[] = {
    {"green_u", kStretch}, {"green_v", kStretch}, {"soft_u", kStretch}, {"soft_v", kStretch},
    {"green_uv", kShear},  {"bend_u", kBending},  {"bend_v", kBending}, {"bend_d", kBending},
};

}  // namespace

std::optional<UsualRange> usual_range(const Term& term) {
  const std::string& law = term.law.name;
  if (law != "linear" && law != "hermite_stiffness" && law != "bspline_stiffness")
    return std::nullopt;
  for (const UsualRow& row : kUsual)
    if (term.strain.name == row.strain) return row.usual;
  return std::nullopt;
}

}  // namespace tenter::model
