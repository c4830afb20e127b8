// SPDX-License-Identifier: Apache-2.0
#include "client/cli/app.h"

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "client/cli/commands/commands.h"
#include "client/cli/context.h"
#include "client/cli/help.h"
#include "client/cli/output.h"
#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

constexpr const char* kDescription =
    "Tenter finds what a simulation of a deformable object gets wrong, why, and which model would "
    "be right, from "
    "measured data. A server (tenterd) keeps captures and runs jobs; this command talks to it over "
    "DDS. Commands "
    "on files alone (capture import, validate, show, export; model; scene) need no server.\n"
    "\n"
    "A capture is one specimen under one protocol, in one file. A model is a list of terms in a "
    "JSON document. A job "
    "fits a model to captures, simulates them, or diagnoses what the model misses; it also "
    "simulates "
    "scenes: a mesh, what holds and pulls it, and a protocol.\n"
    "\n"
    "With --json every command prints exactly one JSON value on standard output; an error is "
    "{\"error\": {\"kind\", "
    "\"code\", \"message\"}}. Progress goes to standard error. Environment: TENTER_DOMAIN, "
    "TENTER_SERVER, TENTER_USER, "
    "NO_COLOR.\n"
    "EXAMPLES\n"
    "    tenter capture import pull.csv --describe pull.json\n"
    "    tenter diagnose pull.h5 --report report.html\n"
    "    tenter --json diagnose pull.h5 | jq '.verdicts[].effect'\n"
    "    tenter job list\n";

/// Whether an argument list asks for JSON, for errors before it is parsed.
bool asks_for_json(int argc, const char* const* argv) {
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--json") return true;
  return false;
}

int complain(const Context& context, const Error& error) {
  if (context.json) {
    Json value = error_json(error);
    for (const auto& [key, text] : context.details) value["error"][key] = text;
    print_json(value);
  } else {
    std::cout << std::flush;
    std::cerr << "tenter: " << report::printable(error.message) << '\n';
  }
  std::cout << std::flush;
  return static_cast<int>(error.kind);
}

/// CLI11's sentences, with the page that helps.
Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* at = &app;
  std::string command = "tenter";
  while (!at->get_subcommands().empty()) {
    at = at->get_subcommands().front();
    command += " " + at->get_name();
  }
  std::string message = error.what();
  if (const std::size_t end = message.find('\n'); end != std::string::npos) message.resize(end);
  const std::vector<const CLI::App*> commands = at->get_subcommands({});
  if (!commands.empty() && at->get_subcommands().empty()) {
    const std::vector<std::string> rest = app.remaining(true);
    message = "a command is missing";
    if (!rest.empty()) message = "there is no command '" + rest.front() + "' here";
    if (!rest.empty() && rest.front().starts_with('-'))
      message = "there is no option '" + rest.front() + "'";
    std::string known;
    for (const CLI::App* c : commands) known += (known.empty() ? "" : ", ") + c->get_name();
    message += "; the commands are " + known;
  }
  return Error{ErrorKind::bad_input, message + " (see `" + command + " --help`)"};
}

}  // namespace

std::unique_ptr<CLI::App> make_app(Context& context) {
  auto app = std::make_unique<CLI::App>("measure, fit and diagnose deformable objects", "tenter");
  use_manual_pages(*app);
  app->footer(kDescription);
  app->set_version_flag("--version", "tenter " TENTER_VERSION, "Print the version.");
  app->set_help_flag("-h,--help", "Print this page; `tenter COMMAND --help` prints the command's.");
  app->require_subcommand(1);
  app->fallthrough();
  app->option_defaults()->always_capture_default(false);
  app->add_flag("--json", context.json, "One JSON value on standard output, also for errors.");
  app->add_flag("-q,--quiet", context.quiet, "No progress display.");
  app->add_option("--domain", context.domain,
                  "DDS domain of the server. Default: $TENTER_DOMAIN, else 42.")
      ->type_name("N")
      ->check(CLI::Range(0, 232));
  app->add_option(
         "--server", context.server,
         "Name of the server where several share a domain. Default: $TENTER_SERVER, else any.")
      ->type_name("NAME");
  app->add_option(
         "--user", context.user,
         "Who asks: letters, digits, '_', '-', '.'. Default: $TENTER_USER, else the login name.")
      ->type_name("NAME");
  app->add_option("--timeout", context.timeout_s,
                  "How long to wait for the server to answer, in seconds. Default: 10.")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.1, 86400.0));
  app->add_option("--colour", context.colour, "auto, always or never. Default: auto.")
      ->type_name("WHEN")
      ->check(CLI::IsMember({"auto", "always", "never"}));

  add_diagnose(*app, context);
  add_fit(*app, context);
  add_simulate(*app, context);
  add_residuals(*app, context);
  add_report(*app, context);
  add_capture(*app, context);
  add_model(*app, context);
  add_effects(*app, context);
  add_scene(*app, context);
  add_job(*app, context);
  add_server(*app, context);
  add_completion(*app, context);
  return app;
}

int run(int argc, const char* const* argv) {
  Context context;
  try {
    const std::unique_ptr<CLI::App> app = make_app(context);
    try {
      app->parse(argc, argv);
    } catch (const CLI::Success& asked) {  // --help, --version
      return app->exit(asked, std::cout, std::cerr);
    } catch (const CLI::ParseError& error) {
      context.json = asks_for_json(argc, argv);
      if (argc <= 1) {
        std::cerr << app->help();
        return static_cast<int>(ErrorKind::bad_input);
      }
      return complain(context, usage_error(*app, error));
    }
    if (!context.command) return complain(context, Error{ErrorKind::internal, "no command ran"});
    const Expected<void> done = context.command();
    if (!done) return complain(context, done.error());
    std::cout << std::flush;
    if (!std::cout)
      return complain(context, Error{ErrorKind::no_space, "standard output could not be written"});
    return 0;
  } catch (const std::exception& error) {
    return complain(context,
                    Error{ErrorKind::internal, std::string("a defect of tenter: ") + error.what()});
  }
}

}  // namespace tenter::cli
