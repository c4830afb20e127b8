// SPDX-License-Identifier: GPL-3.0-or-later
// What a diagnosis says, of curves and of sheets, as parts of result.json (schema "tenter.result",
// whose keys common/report/README.md lists).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/diagnosis/findings.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::jobs {

/// Everything that a result says beside its captures, figures and parts of its own.
nlohmann::json findings_json(const std::string& kind, const diagnosis::Findings& findings,
                             const diagnosis::Reference& baseline,
                             const diagnosis::Reference& extended);

nlohmann::json error_json(const std::optional<diagnosis::Score>& score);

}  // namespace tenter::jobs
