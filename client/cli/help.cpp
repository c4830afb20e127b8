// SPDX-License-Identifier: Apache-2.0
#include "client/cli/help.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <sstream>

#include "client/cli/context.h"

namespace tenter::cli {

namespace {

constexpr const char* kExamples = "EXAMPLES\n";

/// Paragraphs filled to the width, lines that begin with a blank as they are.
std::string filled(const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream lines(text);
  std::string out, line, open;
  const std::string margin(indent, ' ');
  const auto flush = [&] {
    if (!open.empty()) out += margin + open + "\n";
    open.clear();
  };
  while (std::getline(lines, line)) {
    if (line.empty() || line[0] == ' ') {
      flush();
      out += line.empty() ? "\n" : margin + line + "\n";
      continue;
    }
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      if (!open.empty() && indent + open.size() + 1 + word.size() > width) flush();
      open += (open.empty() ? "" : " ") + word;
    }
  }
  flush();
  return out;
}

class ManualPage : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const override {
    const std::size_t width =
        static_cast<std::size_t>(std::min(terminal_width(STDOUT_FILENO), 100));
    std::string page = "NAME\n" + filled(name + " - " + app->get_description(), 4, width);
    page += "\nSYNOPSIS\n    " + synopsis(app, name) + "\n";

    std::string footer = app->get_footer();
    std::string examples;
    if (const std::size_t at = footer.find(kExamples); at != std::string::npos) {
      examples = footer.substr(at + std::string(kExamples).size());
      footer.resize(at);
    }
    if (!footer.empty()) page += "\nDESCRIPTION\n" + filled(footer, 4, width);
    while (page.size() > 1 && page.compare(page.size() - 2, 2, "\n\n") == 0) page.pop_back();

    page += commands(app, width) + arguments(app, width) + options(app, width);
    if (!examples.empty()) page += "\nEXAMPLES\n" + examples;
    return page + exit_status(app);
  }

 private:
  static std::string synopsis(const CLI::App* app, const std::string& name) {
    std::string line = name + (app->get_parent() == nullptr ? " [OPTION]..." : "");
    if (app->get_parent() != nullptr &&
        !app->get_options([](const CLI::Option* o) { return o->nonpositional(); }).empty())
      line += " [OPTION]...";
    for (const CLI::Option* option :
         app->get_options([](const CLI::Option* o) { return o->get_positional(); })) {
      std::string word = option->get_name(true, false);
      if (option->get_expected_max() > 1) word += "...";
      line += " " + (option->get_required() ? word : "[" + word + "]");
    }
    if (!app->get_subcommands({}).empty()) line += " COMMAND";
    return line;
  }

  static std::string commands(const CLI::App* app, std::size_t width) {
    std::string text;
    for (const CLI::App* command : app->get_subcommands({}))
      text += "    " + command->get_name() + "\n" + filled(command->get_description(), 8, width);
    return text.empty() ? "" : "\nCOMMANDS\n" + text;
  }

  static std::string arguments(const CLI::App* app, std::size_t width) {
    std::string text;
    for (const CLI::Option* option :
         app->get_options([](const CLI::Option* o) { return o->get_positional(); }))
      text += "    " + option->get_name(true, false) + "\n" +
              filled(option->get_description(), 8, width);
    return text.empty() ? "" : "\nARGUMENTS\n" + text;
  }

  static std::string options(const CLI::App* app, std::size_t width) {
    std::string text;
    for (const CLI::Option* option :
         app->get_options([](const CLI::Option* o) { return o->nonpositional(); })) {
      std::string names = option->get_name(false, true);
      if (const std::size_t comma = names.find(','); comma != std::string::npos)
        names.insert(comma + 1, " ");
      text += "    " + names;
      const std::string type = option->get_type_name();  // "N:INT in [0 - 232]": only the name
      if (!type.empty()) text += " " + type.substr(0, type.find(':'));
      text += "\n";
      std::string words = option->get_description();
      if (option->get_type_size() != 0 && !option->get_default_str().empty())
        words += " Default: " + option->get_default_str() + ".";
      text += filled(words, 8, width);
    }
    if (app->get_parent() != nullptr)
      text += filled(
          "The options of `tenter --help` (--json, --domain, --user and others) may be given here "
          "too.",
          4, width);
    return "\nOPTIONS\n" + text;
  }

  static std::string exit_status(const CLI::App* app) {
    if (app->get_parent() != nullptr)
      return "\nEXIT STATUS\n    0 done, 1 internal error, 2 bad input, 3 not found, 4 refused, 5 "
             "no server,\n"
             "    6 no space, 7 job failed, 8 cancelled; see `tenter --help`.\n";
    return "\nEXIT STATUS\n"
           "    0   done\n"
           "    1   internal: a defect of tenter\n"
           "    2   bad input: a file, option or document is wrong\n"
           "    3   not found: no such job, capture, model or file\n"
           "    4   refused: quota, state or permission forbids it\n"
           "    5   unavailable: no server, time-out, connection lost\n"
           "    6   no space: disk full or quota of the file system\n"
           "    7   job failed: it ran and ended without a result\n"
           "    8   cancelled: stopped by the user\n";
  }
};

}  // namespace

void use_manual_pages(CLI::App& app) {
  app.formatter(std::make_shared<ManualPage>());
}

}  // namespace tenter::cli
