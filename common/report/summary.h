// SPDX-License-Identifier: Apache-2.0
// What a result says in one sentence, the same in the page's title and on the terminal.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/report/json_access.h"

namespace tenter::report {

/// "Cause found: internal friction." and the like, from the verdicts; for fits, the error reached.
std::string headline(const Json& result);

/// "Diagnosis of 2 captures with stvk_orthotropic".
std::string subject(const Json& result);

/// Whether the result's model is more than the baseline: effects or corrections were added.
bool extends_baseline(const Json& result);

/// Parses a result document, also that of a simulated scene; another schema or broken JSON is
/// bad_input.
Expected<Json> parse_document(const std::string& result_json);

/// The same without simulated scenes, which are bad_input too.
Expected<Json> parse_result(const std::string& result_json);

}  // namespace tenter::report
