// SPDX-License-Identifier: Apache-2.0
#include "client/cli/context.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace tenter::cli {

Expected<client::Client> Context::connect() const {
  client::ClientOptions options;
  if (domain >= 0) options.domain = domain;
  options.server = server;
  options.user = user;
  options.timeout = std::chrono::milliseconds(static_cast<long long>(timeout_s * 1000.0));
  return client::Client::connect(options);
}

bool Context::colour_output() const {
  if (json || colour == "never") return false;
  if (colour == "always") return true;
  const char* forbidden = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  return isatty(STDOUT_FILENO) == 1 && (forbidden == nullptr || *forbidden == '\0') &&
         (terminal == nullptr || std::string(terminal) != "dumb");
}

int terminal_width(int descriptor) {
  winsize size{};
  if (isatty(descriptor) == 1 && ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
    return std::clamp<int>(size.ws_col, 40, 200);
  return 90;
}

}  // namespace tenter::cli
