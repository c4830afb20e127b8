// SPDX-License-Identifier: Apache-2.0
// Fast DDS logs in colour to standard output unless told otherwise before its first participant.
#pragma once

#include <string>

namespace tenter::wire {

/// Sends its errors and warnings to set_wire_log's function, or nowhere. Repeats do nothing.
void install_quiet_log();

/// The last error it logged, for a message of ours; "" if none.
std::string wire_log_tail();

}  // namespace tenter::wire
