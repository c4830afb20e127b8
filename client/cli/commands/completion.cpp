// SPDX-License-Identifier: Apache-2.0
#include "client/cli/completion.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/output.h"

namespace tenter::cli {

void add_completion(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("completion", "print a completion script for a shell");
  command->footer(
      "EXAMPLES\n    source <(tenter completion bash)\n    tenter completion zsh > "
      "~/.zfunc/_tenter\n");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "bash or zsh")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh"}));
  command->callback([&app, &context, shell] {
    context.command = [&app, &context, shell]() -> Expected<void> {
      const Expected<std::string> script = completion_script(app, *shell);
      if (!script) return tl::unexpected(script.error());
      if (context.json)
        print_json({{"shell", *shell}, {"script", *script}});
      else
        print_text(*script);
      return {};
    };
  });
}

}  // namespace tenter::cli
