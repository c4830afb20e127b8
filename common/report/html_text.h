// SPDX-License-Identifier: Apache-2.0
// Text that enters an HTML page.
#pragma once

#include <string>
#include <string_view>

namespace tenter::report {

/// For element content and double-quoted attributes; control characters other than line feed and
/// tab are dropped.
std::string escape_html(std::string_view text);

}  // namespace tenter::report
