// SPDX-License-Identifier: Apache-2.0
// Shell completion scripts, made from the tree of commands so that they never lag behind it.
#pragma once

#include <string>

#include "common/base/error.h"

namespace CLI {
class App;
}

namespace tenter::cli {

/// `shell` is "bash" or "zsh".
Expected<std::string> completion_script(const CLI::App& app, const std::string& shell);

}  // namespace tenter::cli
