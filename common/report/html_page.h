// SPDX-License-Identifier: Apache-2.0
// The frame of a report page: head, style sheet, script. Nothing is loaded from anywhere, and the
// page's own policy lets the browser run this one script and fetch nothing.
#pragma once

#include <string>
#include <string_view>

namespace tenter::report {

/// `title` is plain text, `body` is HTML.
std::string html_page(std::string_view title, std::string_view body);

}  // namespace tenter::report
