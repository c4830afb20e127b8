// SPDX-License-Identifier: Apache-2.0
// What every command has in hand: the global options, the way to the server, and where the parser
// leaves the command that is to run.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "client/api/client.h"
#include "common/base/error.h"

namespace tenter::cli {

class Context {
 public:
  bool json = false;
  bool quiet = false;
  int domain = -1;  ///< -1: not given
  std::string server;
  std::string user;
  double timeout_s = 10.0;
  std::string colour = "auto";

  /// Set by the command that was parsed.
  std::function<Expected<void>()> command;

  /// What an error object carries besides its message, e.g. {"job_id", "17"}.
  std::map<std::string, std::string> details;

  Expected<client::Client> connect() const;

  /// Colours on standard output: asked for, or a terminal and NO_COLOR not set.
  bool colour_output() const;
};

/// Columns of the terminal behind a file descriptor; 90 where there is none.
int terminal_width(int descriptor);

}  // namespace tenter::cli
