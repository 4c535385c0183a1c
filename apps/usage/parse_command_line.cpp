// SPDX-License-Identifier: Apache-2.0
#include "apps/usage/parse_command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>

#include "apps/settings/train_settings.h"

namespace vesta::app {
namespace {

using Option = schema::Field<gs::TrainOptions>;

struct GivenFlag {
  std::string name;
  std::optional<std::string> value;  // the text after "="
};

bool IsFlag(const std::string& word) { return word.size() > 1 && word[0] == '-'; }

bool IsHelp(const std::string& word) { return word == "--help" || word == "-help" || word == "-h"; }

GivenFlag SplitFlag(const std::string& word) {
  const std::size_t begin = word.starts_with("--") ? 2 : 1, equals = word.find('=');
  if (equals == std::string::npos) return {word.substr(begin), std::nullopt};
  return {word.substr(begin, equals - begin), word.substr(equals + 1)};
}

// A flag of ProgramFlags() or of a training option; both null if unknown.
struct FlagFound {
  const schema::Field<Flags>* own = nullptr;
  const char* if_bare = nullptr;  // FlagRow::if_bare
  const Option* option = nullptr;
  const schema::FieldInfo* info() const {
    return own ? static_cast<const schema::FieldInfo*>(own) : static_cast<const schema::FieldInfo*>(option);
  }
};

FlagFound FindFlag(const std::string& name, const CommandInfo& command) {
  for (const FlagRow& row : ProgramFlags()) {
    if ((row.commands & command.command) && row.field.name == name) return {.own = &row.field, .if_bare = row.if_bare};
  }
  for (const Option& option : gs::TrainFields()) {
    if (option.flag && option.flag == name && TakesOption(command, option)) return {.option = &option};
  }
  return {};
}

// Also accepts --noNAME for a switch and sets its value to false.
FlagFound FindGiven(const CommandInfo& command, GivenFlag* flag) {
  FlagFound found = FindFlag(flag->name, command);
  if (found.info() || flag->value || !flag->name.starts_with("no")) return found;
  found = FindFlag(flag->name.substr(2), command);
  if (!found.info() || found.info()->kind != schema::Kind::kSwitch) return {};
  flag->value = "false";
  return found;
}

// "did you mean --NAME? " with the command's most similar flag, or empty.
std::string MeantFlag(const std::string& name, const CommandInfo& command) {
  std::vector<std::string> known;
  for (const ListedFlag& flag : FlagsOf(command)) known.push_back("--" + flag.name);
  for (const ListedFlag& option : OptionsOf(command)) {
    if (!option.field->flag) known.push_back("--set " + option.name);
  }
  const std::vector<std::string> nearest = schema::Nearest("--" + name, known, 1);
  return nearest.empty() ? "" : fmt::format("did you mean {}? ", nearest[0]);
}

[[noreturn]] void RefuseFlag(const GivenFlag& flag, const CommandInfo& command) {
  const std::string& name = flag.name;
  if (name == "low_pass") throw UsageError("--low_pass: this flag is now called --eps2d");
  std::vector<const char*> takers;
  for (const CommandInfo& other : Commands()) {
    GivenFlag copy = flag;
    if (FindGiven(other, &copy).info()) takers.push_back(other.name);
  }
  if (takers.empty()) {
    throw UsageError(
        fmt::format("--{}: no such flag; {}`vesta help {}` lists them", name, MeantFlag(name, command), command.name));
  }
  throw UsageError(fmt::format("--{}: not a flag of {}, but of {}; `vesta help {}` lists its flags", name, command.name,
                               fmt::join(takers, ", "), command.name));
}

[[noreturn]] void RefuseKey(const std::string& key, const CommandInfo& command) {
  if (const auto renamed = gs::RenamedOptions().find(key); renamed != gs::RenamedOptions().end()) {
    throw UsageError(fmt::format("--set {}: this option is now called {}", key, renamed->second));
  }
  std::vector<std::string> known;
  for (const ListedFlag& option : OptionsOf(command)) known.push_back(option.name);
  const std::vector<std::string> nearest = schema::Nearest(key, known);
  throw UsageError(fmt::format(
      "--set {}: {}; {}`vesta help {} --all` lists them", key,
      schema::Find(gs::TrainFields(), key) ? fmt::format("not an option of {}", command.name) : "no such option",
      nearest.empty() ? "" : fmt::format("nearest: {}; ", fmt::join(nearest, ", ")), command.name));
}

// Throws UsageError if the value is invalid.
GivenOption CheckedOption(const std::string& given, const Option& option, const std::string& value) {
  gs::TrainOptions scratch;
  if (!option.Set(value, scratch)) throw UsageError(fmt::format("{}={}: {}", given, value, option.Requirement()));
  return {&option, value};
}

GivenOption OptionOfSet(const std::string& text, const CommandInfo& command) {
  const std::size_t equals = text.find('=');
  const std::string key = text.substr(0, equals);
  const Option* option = schema::Find(gs::TrainFields(), key);
  if (!option || !TakesOption(command, *option)) RefuseKey(key, command);
  if (equals == std::string::npos) {
    throw UsageError(fmt::format("--set {}: its value is missing; write --set {}={}", key, key, option->Placeholder()));
  }
  return CheckedOption("--set " + key, *option, text.substr(equals + 1));
}

// Parses the flag at words[*at], and its value if it is the next word.
void TakeFlag(const std::vector<std::string>& words, std::size_t* at, CommandLine* line) {
  GivenFlag flag = SplitFlag(words[*at]);
  const FlagFound found = FindGiven(*line->command, &flag);
  if (!found.info()) RefuseFlag(flag, *line->command);
  if (!flag.value && found.info()->kind == schema::Kind::kSwitch) flag.value = "true";
  if (!flag.value && found.if_bare) flag.value = found.if_bare;
  const std::string given = "--" + flag.name;
  if (!flag.value) {
    if (*at + 1 == words.size()) {
      throw UsageError(fmt::format("{}: its value is missing; write {}={}", given, given, found.info()->Placeholder()));
    }
    flag.value = words[++*at];
  }
  if (found.option) {
    line->options.push_back(CheckedOption(given, *found.option, *flag.value));
  } else if (found.own->name == "set") {
    line->options.push_back(OptionOfSet(*flag.value, *line->command));
  } else if (!found.own->Set(*flag.value, line->flags)) {
    throw UsageError(fmt::format("{}={}: {}", given, *flag.value, found.own->Requirement()));
  }
}

void CheckArguments(const CommandLine& line) {
  const CommandInfo& command = *line.command;
  const std::string form = UsageForm(command);
  const std::size_t most = command.arguments.size() + (command.optional ? 1 : 0);
  if (line.arguments.size() > most && !command.repeats) {
    throw UsageError(fmt::format("{}: unexpected argument; the form is `{}`", line.arguments[most], form));
  }
  // A checkpoint contains the scene and the output folder.
  if (!line.flags.resume.empty()) return;
  if (line.arguments.size() < command.arguments.size()) {
    throw UsageError(fmt::format("{} is missing; the form is `{}`", command.arguments[line.arguments.size()], form));
  }
  if (command.output && line.flags.out.empty()) {
    throw UsageError(fmt::format("--out={} is missing; the form is `{}`", command.output, form));
  }
}

// Flags of options that only the help with --all lists.
constexpr std::string_view kRareFlags[] = {"antialias", "eps2d"};

}  // namespace

void RefuseCommand(const std::string& name) {
  std::vector<std::string> names;
  for (const CommandInfo& command : Commands()) names.emplace_back(command.name);
  const std::vector<std::string> nearest = schema::Nearest(name, names, 1);
  throw UsageError(fmt::format("{}: no such command; {}the first word is {} or help", name,
                               nearest.empty() ? "" : fmt::format("did you mean {}? ", nearest[0]),
                               fmt::join(names, ", ")));
}

CommandLine ParseCommandLine(const std::vector<std::string>& words) {
  if (words.empty()) throw UsageError("no command; `vesta help` lists them");
  if (words[0] == "--version") return {nullptr, {"version"}};
  if (words[0] == "help" || IsHelp(words[0])) return {nullptr, {words.begin() + 1, words.end()}};
  CommandLine line{FindCommand(words[0]), {}};
  if (!line.command) RefuseCommand(words[0]);
  const auto dashes = std::find(words.begin(), words.end(), "--");
  if (std::find_if(words.begin(), dashes, IsHelp) != dashes) {
    const bool all = std::find(words.begin(), dashes, "--all") != dashes;
    return {nullptr, all ? std::vector<std::string>{words[0], "--all"} : std::vector<std::string>{words[0]}};
  }
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "--") {
      line.arguments.insert(line.arguments.end(), words.begin() + static_cast<std::ptrdiff_t>(i) + 1, words.end());
      break;
    }
    if (IsFlag(words[i])) {
      TakeFlag(words, &i, &line);
    } else {
      line.arguments.push_back(words[i]);
    }
  }
  CheckArguments(line);
  return line;
}

std::vector<ListedFlag> FlagsOf(const CommandInfo& command) {
  std::vector<ListedFlag> flags;
  for (const FlagRow& row : ProgramFlags()) {
    if (!(row.commands & command.command)) continue;
    const std::string value = row.field.name == "preset" ? kDefaultPreset : row.field.Text(Flags());
    flags.push_back(
        {row.field.name, &row.field, row.group, value, (row.rare_for & command.command) != 0, row.if_bare != nullptr});
  }
  for (ListedFlag option : OptionsOf(command)) {
    if (!option.field->flag) continue;
    option.name = option.field->flag;
    option.only_in_all = std::ranges::find(kRareFlags, option.name) != std::end(kRareFlags);
    flags.push_back(std::move(option));
  }
  std::ranges::stable_sort(flags, {}, &ListedFlag::group);
  return flags;
}

std::vector<ListedFlag> OptionsOf(const CommandInfo& command) {
  std::vector<ListedFlag> options;
  const gs::TrainOptions defaults = PresetOf(command, kDefaultPreset);
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    if (TakesOption(command, field)) options.push_back({field.name, &field, GroupOf(field), field.Text(defaults)});
  }
  return options;
}

}  // namespace vesta::app
