// SPDX-License-Identifier: Apache-2.0
// The tables of a result as HTML, one function per section; each returns "" where the result has
// nothing to show.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report {

std::string summary_cards(const Json& result);
std::string verdict_table(const Json& result);
std::string capture_table(const Json& result);
std::string parameter_table(const Json& result);
std::string path_table(const Json& result);
std::string screen_table(const Json& result);
std::string checklist_table(const Json& result);
std::string model_table(const Json& result);

}  // namespace tenter::report
