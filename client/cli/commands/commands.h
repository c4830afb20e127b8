// SPDX-License-Identifier: Apache-2.0
// The groups of commands, one file each. Each function adds its group to the tree; a parsed command
// leaves what it does in Context::command.
#pragma once

namespace CLI {
class App;
}

namespace tenter::cli {

class Context;

void add_capture(CLI::App& app, Context& context);
void add_completion(CLI::App& app, Context& context);
void add_diagnose(CLI::App& app, Context& context);
void add_effects(CLI::App& app, Context& context);
void add_fit(CLI::App& app, Context& context);
void add_job(CLI::App& app, Context& context);
void add_model(CLI::App& app, Context& context);
void add_report(CLI::App& app, Context& context);
void add_residuals(CLI::App& app, Context& context);
void add_scene(CLI::App& app, Context& context);
void add_server(CLI::App& app, Context& context);
void add_simulate(CLI::App& app, Context& context);

}  // namespace tenter::cli
