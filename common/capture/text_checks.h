// SPDX-License-Identifier: Apache-2.0
// Private: texts and names that captures may hold, and how messages speak of frames.
#pragma once

#include <string>

#include "common/capture/capture.h"

namespace tenter::capture {

/// The text in quotes.
std::string quoted(const std::string& text);

/// A name of letters, digits and '_', at most 200 of them.
bool well_formed(const std::string& name);

/// Why a text cannot be kept, or "": valid UTF-8 without control characters (line end and tab
/// apart), so that it can go into JSON, pages and terminals as it is.
std::string trouble_in(const std::string& text);

/// "run 3, frame 17" of frame index i; the runs have been checked.
std::string at_frame(const Capture& capture, std::size_t i);

}  // namespace tenter::capture
