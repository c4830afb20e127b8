// SPDX-License-Identifier: Apache-2.0
// Every help page has what a manual page has, and names what the parser knows.
#include "client/cli/help.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <sstream>

#include "client/cli/app.h"
#include "client/cli/context.h"

namespace tenter::cli {
namespace {

void check_page(const CLI::App& app, const std::string& path) {
  const std::string page = app.get_formatter()->make_help(&app, path, CLI::AppFormatMode::Normal);
  for (const char* section : {"NAME\n", "\nSYNOPSIS\n", "\nOPTIONS\n", "\nEXIT STATUS\n"})
    EXPECT_NE(page.find(section), std::string::npos) << path << " lacks " << section;
  EXPECT_EQ(page.find("\n\n\n"), std::string::npos) << path;
  const std::vector<const CLI::App*> commands = app.get_subcommands({});
  EXPECT_TRUE(!commands.empty() || page.find("\nEXAMPLES\n    ") != std::string::npos) << path;
  EXPECT_FALSE(app.get_description().empty()) << path;
  for (const CLI::Option* option : app.get_options()) {
    EXPECT_FALSE(option->get_description().empty()) << path << " " << option->get_name();
    for (const std::string& name : option->get_lnames())
      EXPECT_NE(page.find("--" + name), std::string::npos) << path << " " << name;
  }
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    EXPECT_LE(line.size(), 110u) << path << ": " << line;
  for (const CLI::App* command : commands) {
    EXPECT_NE(page.find("    " + command->get_name() + "\n"), std::string::npos) << path;
    check_page(*command, path + " " + command->get_name());
  }
}

TEST(Help, EveryPageIsWhole) {
  Context context;
  const std::unique_ptr<CLI::App> app = make_app(context);
  check_page(*app, "tenter");
}

TEST(Help, TheFirstPageSaysWhatTheExitCodesMean) {
  Context context;
  const std::unique_ptr<CLI::App> app = make_app(context);
  const std::string page = app->help();
  for (const char* line : {"2   bad input", "3   not found", "4   refused", "5   unavailable",
                           "6   no space", "7   job failed", "8   cancelled"})
    EXPECT_NE(page.find(line), std::string::npos) << line;
}

TEST(Help, ExamplesParse) {
  // each example that calls tenter alone must be understood by the parser
  std::vector<const CLI::App*> all;
  Context context;
  const std::unique_ptr<CLI::App> app = make_app(context);
  all.push_back(app.get());
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const CLI::App* command : all[i]->get_subcommands({})) all.push_back(command);
  int tried = 0;
  for (const CLI::App* command : all) {
    std::istringstream lines(command->get_footer());
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("    tenter ", 0) != 0 || line.find_first_of("*'$") != std::string::npos)
        continue;
      line = line.substr(11, line.find_first_of("|><") - 11);
      Context fresh;
      const std::unique_ptr<CLI::App> parser = make_app(fresh);
      // examples name files that are not here
      if (line.find("submit pull.h5") != std::string::npos) continue;
      EXPECT_NO_THROW(parser->parse(line, false)) << line;
      ++tried;
    }
  }
  EXPECT_GT(tried, 20);
}

}  // namespace
}  // namespace tenter::cli
