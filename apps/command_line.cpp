#include "apps/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gflags/gflags.h>

#include <optional>

#include "apps/flag_values.h"

namespace vesta::app {
namespace {

struct GivenFlag {
  std::string name;
  std::optional<std::string> value;  // what follows "="
};

bool IsFlag(const std::string& word) { return word.size() > 1 && word[0] == '-'; }

GivenFlag SplitFlag(const std::string& word) {
  const std::size_t begin = word.starts_with("--") ? 2 : 1, equals = word.find('=');
  if (equals == std::string::npos) return {word.substr(begin), std::nullopt};
  return {word.substr(begin, equals - begin), word.substr(equals + 1)};
}

bool IsHelp(const std::string& word) { return word == "--help" || word == "-help" || word == "-h"; }

bool IsSwitch(const FlagRule& rule) { return std::holds_alternative<Switch>(rule.values); }

// The rule of a flag; for a switch also by its negation, --noNAME.
const FlagRule* RuleOf(const GivenFlag& flag) {
  if (const FlagRule* rule = FindFlag(flag.name)) return rule;
  if (!flag.name.starts_with("no") || flag.value) return nullptr;
  const FlagRule* rule = FindFlag(flag.name.substr(2));
  return rule && IsSwitch(*rule) ? rule : nullptr;
}

const FlagRule& CheckFlagName(const GivenFlag& flag, const CommandInfo& command) {
  const FlagRule* rule = RuleOf(flag);
  if (!rule) {
    throw UsageError(fmt::format("--{}: no such flag; `vesta help {}` lists them", flag.name, command.name));
  }
  if (rule->commands & command.command) return *rule;
  std::vector<const char*> takers;
  for (const CommandInfo& other : Commands()) {
    if (rule->commands & other.command) takers.push_back(other.name);
  }
  throw UsageError(fmt::format("--{}: not a flag of {}, but of {}; `vesta help {}` lists those it takes", flag.name,
                               command.name, fmt::join(takers, " and "), command.name));
}

// Checks the flags among the words and returns the others.
std::vector<std::string> CheckWords(const std::vector<std::string>& words, const CommandInfo& command) {
  std::vector<std::string> arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--") {
      arguments.insert(arguments.end(), words.begin() + static_cast<std::ptrdiff_t>(i) + 1, words.end());
      break;
    }
    if (!IsFlag(words[i])) {
      arguments.push_back(words[i]);
      continue;
    }
    GivenFlag flag = SplitFlag(words[i]);
    const FlagRule& rule = CheckFlagName(flag, command);
    if (!flag.value && IsSwitch(rule)) continue;
    if (!flag.value && i + 1 == words.size()) {
      throw UsageError(
          fmt::format("--{}: its value is missing; write --{}={}", rule.name, rule.name, ValuePlaceholder(rule)));
    }
    CheckFlagValue(rule, flag.value ? *flag.value : words[++i]);
  }
  return arguments;
}

void CheckArguments(const CommandInfo& command, const std::vector<std::string>& arguments) {
  const std::string form = UsageForm(command);
  if (arguments.size() > command.arguments.size()) {
    throw UsageError(fmt::format("{}: too much; the form is `{}`", arguments[command.arguments.size()], form));
  }
  if (arguments.size() < command.arguments.size()) {
    throw UsageError(fmt::format("{} is missing; the form is `{}`", command.arguments[arguments.size()], form));
  }
  if ((FindFlag("out")->commands & command.command) && FLAGS_out.empty()) {
    throw UsageError(fmt::format("--out={} is missing; the form is `{}`", command.output, form));
  }
}

}  // namespace

CommandLine ParseCommandLine(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty()) throw UsageError("no command; `vesta help` lists them");
  if (words[0] == "--version") return {nullptr, {"version"}};
  if (words[0] == "help" || IsHelp(words[0])) return {nullptr, {words.begin() + 1, words.end()}};
  const CommandInfo* command = FindCommand(words[0]);
  if (!command) {
    throw UsageError(fmt::format(
        "{}: no such command; the first word is train, refine, eval, render, bundle_adjust or help", words[0]));
  }
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  for (const std::string& word : rest) {
    if (word == "--") break;
    if (IsHelp(word)) return {nullptr, {command->name}};
  }
  const std::vector<std::string> arguments = CheckWords(rest, *command);
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/false);
  CheckArguments(*command, arguments);
  return {command, arguments};
}

}  // namespace vesta::app
