// SPDX-License-Identifier: GPL-3.0-or-later
// The plots beside the tables of thesis appendix A, as one page of common/report: for each scenario
// force over displacement with the model over the measurement, the profile of a bend, and the sheet
// with what is missed, arrows five times their length.
//
//   AppendixPage page;
//   page.add("14", row, sequences);          // draws every sequence with the row's model
//   write(page.html());
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/estimation/staged/tables/variants.h"

namespace tenter::bench {

class AppendixPage {
 public:
  /// A sequence whose frames have no rest with the model is left out.
  Expected<void> add(const std::string& fabric, const estimation::AppendixRow& row,
                     const std::vector<estimation::RoleSequence>& sequences);
  Expected<std::string> html() const;

 private:
  nlohmann::json captures_ = nlohmann::json::array();
  nlohmann::json figures_ = nlohmann::json::array();
  nlohmann::json meshes_ = nlohmann::json::array();
};

}  // namespace tenter::bench
