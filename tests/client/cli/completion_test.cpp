// SPDX-License-Identifier: Apache-2.0
// The scripts are asked in a real shell what they would offer.
#include "client/cli/completion.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "client/cli/app.h"
#include "client/cli/context.h"

namespace tenter::cli {
namespace {

std::string script(const std::string& shell) {
  Context context;
  const std::unique_ptr<CLI::App> app = make_app(context);
  return completion_script(*app, shell).value();
}

/// What bash offers at the end of these words.
std::set<std::string> offered(const std::string& words) {
  std::string folder =
      (std::filesystem::temp_directory_path() / "tenter-completion-XXXXXX").string();
  const std::filesystem::path home = mkdtemp(folder.data());
  std::ofstream(home / "_tenter") << script("bash");
  std::ofstream(home / "ask")
      << "cd " << home << "/empty\nsource ../_tenter\nCOMP_WORDS=(" << words
      << ")\nCOMP_CWORD=$((${#COMP_WORDS[@]}-1))\n_tenter\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
  std::filesystem::create_directory(home / "empty");
  FILE* shell = popen(("bash " + (home / "ask").string() + " 2>&1").c_str(), "r");
  std::set<std::string> words_offered;
  char line[4096];
  while (std::fgets(line, sizeof line, shell) != nullptr) {
    std::string word(line);
    word.erase(word.find_last_not_of('\n') + 1);
    if (!word.empty()) words_offered.insert(word);
  }
  pclose(shell);
  std::filesystem::remove_all(home);
  return words_offered;
}

TEST(Completion, OffersCommandsOptionsAndValuesOfTheCommandAtHand) {
  EXPECT_EQ(offered("tenter dia"), std::set<std::string>{"diagnose"});
  EXPECT_EQ(offered("tenter job ca"), std::set<std::string>{"cancel"});
  EXPECT_EQ(offered("tenter --json --domain 7 capture ''").count("import"), 1u);
  EXPECT_EQ(offered("tenter diagnose --leave"), std::set<std::string>{"--leave-out"});
  EXPECT_EQ(offered("tenter diagnose x.h5 --dom"), std::set<std::string>{"--domain"});
  EXPECT_EQ(offered("tenter fit --model stvk_iso"),
            (std::set<std::string>{"stvk_isotropic", "stvk_isotropic_spline"}));
  EXPECT_EQ(offered("tenter job list --state c"), std::set<std::string>{"cancelled"});
}

TEST(Completion, ZshScriptIsMadeForEveryCommand) {
  const std::string zsh = script("zsh");
  EXPECT_EQ(zsh.rfind("#compdef tenter\n", 0), 0u);
  for (const char* path :
       {"\"tenter job watch\"", "\"tenter capture import\"", "\"tenter diagnose\""})
    EXPECT_NE(zsh.find(path), std::string::npos) << path;
}

TEST(Completion, OtherShellsAreRefused) {
  Context context;
  const std::unique_ptr<CLI::App> app = make_app(context);
  EXPECT_EQ(completion_script(*app, "fish").error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace tenter::cli
