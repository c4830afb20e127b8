// SPDX-License-Identifier: Apache-2.0
// Both scripts walk the words of the command line down the tree to the command that is being
// completed, then offer its commands and options, the known values of an option, or files.
#include "client/cli/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "common/model/presets.h"

namespace tenter::cli {

namespace {

struct Node {
  std::string path;  ///< "tenter job watch"
  std::vector<std::string> commands;
  std::vector<std::string> flags;
  std::vector<std::string> valued;  ///< options that take a value
};

std::vector<std::string> names_of(const CLI::Option* option) {
  std::vector<std::string> names;
  for (const std::string& s : option->get_snames()) names.push_back("-" + s);
  for (const std::string& l : option->get_lnames()) names.push_back("--" + l);
  return names;
}

void collect(const CLI::App& app, const std::string& path, std::vector<Node>& nodes) {
  Node node;
  node.path = path;
  for (const CLI::Option* option :
       app.get_options([](const CLI::Option* o) { return o->nonpositional(); }))
    for (const std::string& name : names_of(option)) {
      node.flags.push_back(name);
      if (!option->get_type_name().empty()) node.valued.push_back(name);
    }
  const std::size_t here = nodes.size();
  nodes.push_back(node);
  for (const CLI::App* command : app.get_subcommands({})) {
    nodes[here].commands.push_back(command->get_name());
    collect(*command, path + " " + command->get_name(), nodes);
  }
}

std::string joined(const std::vector<std::string>& words, const char* separator = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// Shell code that both shells understand; `tenter_words` and `tenter_current` are set by the
/// caller.
std::string walk(const std::vector<Node>& nodes) {
  std::vector<std::string> paths, valued;
  for (const Node& node : nodes) {
    paths.push_back("\"" + node.path + "\"");
    for (const std::string& name : node.valued)
      if (std::find(valued.begin(), valued.end(), name) == valued.end()) valued.push_back(name);
  }
  std::string code =
      "  local tenter_path=tenter word skip=\n  for word in \"${tenter_words[@]}\"; do\n"
      "    if [[ -n $skip ]]; then skip=; continue; fi\n"
      "    case \"$word\" in\n      " +
      joined(valued, "|") +
      ") skip=1; continue;;\n      -*) continue;;\n    esac\n"
      "    case \"$tenter_path $word\" in\n      " +
      joined(paths, "|") +
      ") tenter_path=\"$tenter_path $word\";;\n    esac\n  done\n"
      "  local commands= options=\n  case \"$tenter_path\" in\n";
  for (const Node& node : nodes) {
    std::vector<std::string> flags = node.flags;
    if (&node != &nodes.front())
      for (const std::string& flag : nodes.front().flags)
        if (std::find(flags.begin(), flags.end(), flag) == flags.end() && flag != "--version")
          flags.push_back(flag);
    code += "    \"" + node.path + "\") commands=\"" + joined(node.commands) + "\"; options=\"" +
            joined(flags) + "\";;\n";
  }
  return code + "  esac\n";
}

std::string values() {
  return "  local values=\n  case \"$tenter_previous\" in\n    --model) values=\"" +
         joined(model::preset_names()) +
         "\";;\n    --format) values=\"table csv json\";;\n    --colour) values=\"auto always "
         "never\";;\n"
         "    --state) values=\"queued running succeeded failed cancelled\";;\n    --kind) "
         "values=\"fit simulate diagnose\";;\n  esac\n";
}

}  // namespace

Expected<std::string> completion_script(const CLI::App& app, const std::string& shell) {
  std::vector<Node> nodes;
  collect(app, "tenter", nodes);
  if (shell == "bash")
    return "# bash completion of tenter; load it with: source <(tenter completion bash)\n_tenter() "
           "{\n"
           "  local current=\"${COMP_WORDS[COMP_CWORD]}\" "
           "tenter_previous=\"${COMP_WORDS[COMP_CWORD-1]}\"\n"
           "  local tenter_words=(\"${COMP_WORDS[@]:1:COMP_CWORD-1}\")\n" +
           walk(nodes) + values() +
           "  COMPREPLY=()\n"
           "  if [[ $current == -* ]]; then\n    COMPREPLY=($(compgen -W \"$options\" -- "
           "\"$current\"))\n"
           "  elif [[ -n $commands && $tenter_previous != -* ]]; then\n    COMPREPLY=($(compgen -W "
           "\"$commands\" -- \"$current\"))\n"
           "  else\n    [[ -n $values ]] && COMPREPLY=($(compgen -W \"$values\" -- \"$current\"))\n"
           "    compopt -o filenames 2>/dev/null\n    local IFS=$'\\n'\n"
           "    COMPREPLY+=($(compgen -f -- \"$current\"))\n  fi\n}\ncomplete -F _tenter tenter\n";
  if (shell == "zsh")
    return "#compdef tenter\n# zsh completion of tenter; put it on $fpath as _tenter, or: source "
           "<(tenter completion zsh)\n_tenter() {\n"
           "  local current=\"$words[CURRENT]\" tenter_previous=\"$words[CURRENT-1]\"\n"
           "  local -a tenter_words\n  tenter_words=(\"${(@)words[2,CURRENT-1]}\")\n" +
           walk(nodes) + values() +
           "  if [[ $current == -* ]]; then\n    compadd -- ${=options}\n"
           "  elif [[ -n $commands && $tenter_previous != -* ]]; then\n    compadd -- "
           "${=commands}\n"
           "  else\n    [[ -n $values ]] && compadd -- ${=values}\n    _files\n  fi\n}\n"
           "if [[ \"$funcstack[1]\" == _tenter ]]; then _tenter \"$@\"; else compdef _tenter "
           "tenter; fi\n";
  return bad_input("completion is made for bash and zsh, not for '" + shell + "'");
}

}  // namespace tenter::cli
