// SPDX-License-Identifier: GPL-3.0-or-later
// What may be asked of a fit beside its stages ("starts", "convex", "samples", "limits" of its
// options), and which of these are right together: told at the door, before a worker starts.
//
//   if (auto ok = check_fit_requests(model, options); !ok) return ok;
//
// Looks at names alone: whether values have the right form is the job's question
// (sheet_fit/sheet_options.h). Pure.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "common/base/error.h"

namespace tenter::jobs {

/// One sentence, bad_input: which two do not go together and why, or what one of them needs.
Expected<void> check_fit_requests(const nlohmann::json& model, const nlohmann::json& options);

/// Whether a law is convex, or is replaced by one that is, whatever its non-negative parameters.
bool is_made_convex(std::string_view law);

}  // namespace tenter::jobs
