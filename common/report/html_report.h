// SPDX-License-Identifier: Apache-2.0
// A result document as one self-contained HTML page: verdicts first, then what they rest on.
//
//   Expected<std::string> page = render_html(result_json);
//
// The same document gives the same bytes. Needs no network, and no script to be read; all text is
// escaped.
#pragma once

#include <string>

#include "common/base/error.h"

namespace tenter::report {

/// A document that is not a result (schema "tenter.result", version 1) is bad_input.
Expected<std::string> render_html(const std::string& result_json);

}  // namespace tenter::report
