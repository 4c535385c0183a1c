// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "apps/usage/help.h"
#include "apps/usage/parse_command_line.h"

namespace vesta::app {
namespace {

constexpr const char* kShells[] = {"bash", "fish", "zsh"};

// Words, files or folders.
struct Values {
  std::vector<std::string> words;
  bool is_file = false, is_folder = false;
};

// Bars separate placeholders: literal words in small letters, stand-ins such as FILE in capitals.
Values ValuesOf(const schema::FieldInfo& field) {
  Values values;
  std::stringstream parts(field.placeholder);
  for (std::string part; std::getline(parts, part, '|');) {
    values.is_folder = values.is_folder || part == "DIR" || part == "SCENE";
    values.is_file = values.is_file || part.starts_with("FILE") || part == "SPLAT";
    const bool is_word = std::ranges::all_of(part, [](char c) { return c >= 'a' && c <= 'z'; });
    if (is_word) values.words.push_back(part);
  }
  for (const char* choice : field.choices) values.words.emplace_back(choice);
  if (field.kind == schema::Kind::kSwitch) values.words = {"true", "false"};
  if (field.may_be_auto) values.words.emplace_back("auto");
  return values;
}

bool IsFolder(std::string_view argument) { return argument == "DIR" || argument == "SCENE"; }

// The completions of --set: every key with "=".
std::string Keys(const CommandInfo& command) {
  std::string keys;
  for (const ListedFlag& option : OptionsOf(command)) keys += (keys.empty() ? "" : " ") + option.name + "=";
  return keys;
}

std::vector<std::string> CommandNames() {
  std::vector<std::string> names = {"help"};
  for (const CommandInfo& command : Commands()) names.emplace_back(command.name);
  return names;
}

// Escapes text inside single quotes of bash and zsh.
std::string Quoted(std::string_view text) {
  std::string quoted;
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted;
}

// The bash case of a command. $flag: the flag whose value is completed, or empty.
std::string BashCase(const CommandInfo& command) {
  std::string flags, values;
  for (const ListedFlag& flag : FlagsOf(command)) {
    if (flag.may_be_bare) flags += " " + flag.Written();
    flags += fmt::format(" {}{}", flag.Written(), flag.is_switch() ? "" : "=");
    const Values of = ValuesOf(*flag.field);
    if (flag.is_switch()) continue;
    if (of.is_folder || of.is_file) {
      values += fmt::format("        --{}) COMPREPLY=($(compgen -{} -W '{}' -- \"$cur\")); return ;;\n", flag.name,
                            of.is_folder ? 'd' : 'f', fmt::join(of.words, " "));
    } else if (flag.name == "set") {
      values += fmt::format("        --set) words='{}' ;;\n", Keys(command));
    } else if (!of.words.empty()) {
      values += fmt::format("        --{}) words='{}' ;;\n", flag.name, fmt::join(of.words, " "));
    }
  }
  return fmt::format("    {})\n      case $flag in\n{}        '') words='{}' ;;\n      esac ;;\n", command.name, values,
                     flags.substr(flags.empty() ? 0 : 1));
}

// The bash cases for the values after --set KEY=.
std::string BashKeyCases() {
  std::string cases;
  for (const ListedFlag& option : OptionsOf(*FindCommand("train"))) {
    const Values of = ValuesOf(*option.field);
    if (!of.words.empty()) cases += fmt::format("      {}) words='{}' ;;\n", option.name, fmt::join(of.words, " "));
  }
  return cases;
}

std::string Bash() {
  std::string script = fmt::format(R"bash(# Completion of vesta for bash.
_vesta() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} flag='' key='' words='' at=$COMP_CWORD
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    COMPREPLY=($(compgen -W '{}' -- "$cur"))
    return
  fi
  # bash makes words of their own of the "=": --set = lm.jacobian = cached
  if [[ $cur == = ]]; then cur='' at=$((at + 1)); fi
  if [[ ${{COMP_WORDS[at-1]}} == = ]]; then
    flag=${{COMP_WORDS[at-2]}}
    if [[ $flag != -* && ${{COMP_WORDS[at-4]}} == --set ]]; then key=$flag flag=--key; fi
    if [[ $flag != -* && ${{COMP_WORDS[at-3]}} == --set ]]; then key=$flag flag=--key; fi
  elif [[ ${{COMP_WORDS[at-1]}} == --set ]]; then
    flag=--set
  fi
  if [[ $flag == --key ]]; then
    case $key in
{}    esac
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
    return
  fi
  case ${{COMP_WORDS[1]}} in
    help)
      case $flag in
        --completion) words='{}' ;;
        '') words='{} --all --man --completion=' ;;
      esac ;;
)bash",
                                   fmt::join(CommandNames(), " "), BashKeyCases(), fmt::join(kShells, " "),
                                   fmt::join(CommandNames(), " "));
  for (const CommandInfo& command : Commands()) script += BashCase(command);
  script += R"bash(  esac
  if [[ -n $flag || $cur == -* || ${COMP_WORDS[1]} == help ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
    if [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *= ]]; then compopt -o nospace; fi
  else
    COMPREPLY=($(compgen -f -- "$cur"))
    compopt -o filenames
  fi
}
complete -F _vesta vesta
)bash";
  return script;
}

// Escapes colons and brackets, which are special for _arguments.
std::string ZshText(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == ':' || c == '[' || c == ']' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return Quoted(escaped);
}

std::string ZshAction(const ListedFlag& flag, const CommandInfo& command) {
  const Values of = ValuesOf(*flag.field);
  if (of.is_folder) return "_files -/";
  if (of.is_file && !of.words.empty()) return fmt::format("{{compadd {}; _files}}", fmt::join(of.words, " "));
  if (of.is_file) return "_files";
  if (flag.name == "set") return fmt::format("compadd -S \"\" -- {}", Keys(command));
  return of.words.empty() ? " " : fmt::format("({})", fmt::join(of.words, " "));
}

std::string Zsh() {
  std::string script = "#compdef vesta\n# Completion of vesta for zsh.\n_vesta() {\n  local -a commands=(\n";
  for (const CommandInfo& command : Commands()) {
    script += fmt::format("    '{}:{}'\n", command.name, Quoted(command.summary));
  }
  script +=
      "    'help:list the flags of a command'\n  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    "
      "return\n  "
      "fi\n  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n    help)\n      "
      "_arguments";
  script += fmt::format(
      " '--all[all flags and options]' '--man[the manual]' '--completion=[a script for a shell]:SHELL:({})' "
      "'1:COMMAND:({})' ;;\n",
      fmt::join(kShells, " "), fmt::join(CommandNames(), " "));
  for (const CommandInfo& command : Commands()) {
    script += fmt::format("    {})\n      _arguments", command.name);
    for (const ListedFlag& flag : FlagsOf(command)) {
      const char* repeats = flag.name == "set" ? "*" : "";
      script += flag.is_switch()
                    ? fmt::format(" \\\n        '{}[{}]'", flag.Written(), ZshText(flag.field->help))
                    : fmt::format(" \\\n        '{}{}={}[{}]:{}{}:{}'", repeats, flag.Written(),
                                  flag.may_be_bare ? "-" : "", ZshText(flag.field->help), flag.may_be_bare ? ":" : "",
                                  ZshText(flag.field->Placeholder()), ZshAction(flag, command));
    }
    for (std::size_t i = 0; i < command.arguments.size(); ++i) {
      const bool repeats = command.repeats && i + 1 == command.arguments.size();
      script += fmt::format(" \\\n        '{}:{}:_files{}'", repeats ? "*" : std::to_string(i + 1),
                            command.arguments[i], IsFolder(command.arguments[i]) ? " -/" : "");
    }
    if (command.optional) {
      script += fmt::format(" \\\n        '{}::{}:_files{}'", command.arguments.size() + 1, command.optional,
                            IsFolder(command.optional) ? " -/" : "");
    }
    script += " ;;\n";
  }
  return script + "  esac\n}\nif [[ $funcstack[1] == _vesta ]]; then _vesta \"$@\"; else compdef _vesta vesta; fi\n";
}

// Escapes text inside single quotes of fish.
std::string FishText(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string Fish() {
  std::string script = "# Completion of vesta for fish.\n";
  for (const CommandInfo& command : Commands()) {
    script += fmt::format("complete -c vesta -n __fish_use_subcommand -f -a {} -d '{}'\n", command.name,
                          FishText(command.summary));
  }
  script += "complete -c vesta -n __fish_use_subcommand -f -a help -d 'list the flags of a command'\n";
  script += fmt::format("complete -c vesta -n '__fish_seen_subcommand_from help' -f -a '{}'\n",
                        fmt::join(CommandNames(), " "));
  const char* const of_help = "complete -c vesta -n '__fish_seen_subcommand_from help' -l";
  script += fmt::format("{} all -f -d 'all flags and options'\n{} man -f -d 'the manual'\n", of_help, of_help);
  script += fmt::format("{} completion -x -a '{}' -d 'a script for a shell'\n", of_help, fmt::join(kShells, " "));
  for (const CommandInfo& command : Commands()) {
    for (const ListedFlag& flag : FlagsOf(command)) {
      const Values of = ValuesOf(*flag.field);
      std::string value = "-x";
      if (flag.is_switch() || flag.may_be_bare) {
        value = "-f";
      } else if (of.is_file && !of.words.empty()) {
        value = fmt::format("-r -a '{}'", fmt::join(of.words, " "));
      } else if (of.is_file || of.is_folder) {
        value = of.is_folder ? "-x -a '(__fish_complete_directories)'" : "-r";
      } else if (flag.name == "set") {
        value = fmt::format("-x -a '{}'", Keys(command));
      } else if (!of.words.empty()) {
        value = fmt::format("-x -a '{}'", fmt::join(of.words, " "));
      }
      script += fmt::format("complete -c vesta -n '__fish_seen_subcommand_from {}' -l {} {} -d '{}'\n", command.name,
                            flag.Written().substr(2), value, FishText(flag.field->help));
    }
  }
  return script;
}

}  // namespace

std::string CompletionScript(const std::string& shell) {
  static const std::map<std::string, std::string (*)()> makers = {{"bash", Bash}, {"fish", Fish}, {"zsh", Zsh}};
  const auto found = makers.find(shell);
  if (found == makers.end()) throw UsageError(fmt::format("--completion={}: it must be bash, fish or zsh", shell));
  return found->second();
}

}  // namespace vesta::app
