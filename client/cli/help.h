// SPDX-License-Identifier: Apache-2.0
// --help as a manual page, made from the tree of commands.
//
// A command's footer holds its long description; what follows a line "EXAMPLES" in it are its
// examples.
#pragma once

namespace CLI {
class App;
}

namespace tenter::cli {

/// For `app` and every command added to it later.
void use_manual_pages(CLI::App& app);

}  // namespace tenter::cli
