// SPDX-License-Identifier: Apache-2.0
// The command `tenter` as a function: parses, runs one command, says how it went.
//
// What a command prints goes to standard output, everything about the work (progress, where a job
// went on) to standard error. With --json standard output holds exactly one JSON value, also when
// the command fails.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace tenter::cli {

class Context;
class HelpTexts;

/// Returns the exit code (common/base/error.h).
int run(int argc, const char* const* argv);

/// The tree of commands; parsing it leaves the command to run in `context`.
std::unique_ptr<CLI::App> make_app(Context& context);

}  // namespace tenter::cli
