// SPDX-License-Identifier: Apache-2.0
// The two halves of `tenter capture`: files, and captures on the server.
#pragma once

namespace CLI {
class App;
}

namespace tenter::cli {

class Context;

void add_capture_files(CLI::App& group, Context& context);
void add_capture_server(CLI::App& group, Context& context);

}  // namespace tenter::cli
