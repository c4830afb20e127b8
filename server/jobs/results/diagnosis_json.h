// SPDX-License-Identifier: GPL-3.0-or-later
// What a diagnosis says, of curves and of sheets, as parts of result.json (schema "tenter.result",
// whose keys common/report/README.md lists).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "server/diagnosis/findings.h"
#include "server/diagnosis/screening/candidate.h"

namespace tenter::jobs {

nlohmann::json verdicts_json(const std::vector<diagnosis::Verdict>& verdicts);
nlohmann::json screen_json(const diagnosis::Screen& screen);
nlohmann::json path_json(const std::vector<diagnosis::PathStep>& path);
nlohmann::json checklist_json(const std::vector<diagnosis::Check>& checklist);

}  // namespace tenter::jobs
